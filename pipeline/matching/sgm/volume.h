// The data that semi-global matching keeps for each pixel and disparity.
#pragma once

#include <cstddef>
#include <cstdint>

#include "pipeline/base/host_device.h"
#include "pipeline/matching/common/bordered_raster.h"
#include "pipeline/matching/sgm/large_array.h"

namespace hexrelief::matching {

// The disparities searched: left(x, y) = right(x - d, y) for min_px <= d < min_px + count.
struct DisparityRange {
    int min_px = 0;
    int count = 0;  // 1..1920, so that 16 bits hold 1/16 px, also on planes that go beyond the range

    bool operator==(const DisparityRange&) const = default;
};

// Returns the range for the pair at half its size: the same disparities, which are half as many px there.
inline DisparityRange at_half_size(const DisparityRange& range) {
    const int min_px = range.min_px >> 1, last_px = (range.min_px + range.count) >> 1;
    return {min_px, last_px - min_px + 1};
}

// The two runs of disparities that are searched at a pixel: from far_run on and from near_run on, which is at
// least a run's length above far_run. Both count from range.min_px. Entries beyond the range have the cost
// kBeyondRange and never win.
struct alignas(4) SearchWindow {
    std::int16_t far_run, near_run;
};
// A range of up to kWholeRange is searched completely, in two long runs; a larger one in two short runs.
inline constexpr int kLongRun = 32, kShortRun = 16, kWholeRange = 2 * kLongRun;
inline constexpr SearchWindow kWholeWindow{0, kLongRun};
HEXRELIEF_HD constexpr bool is_searched_wholly(const DisparityRange& range) {
    return range.count <= kWholeRange;
}
HEXRELIEF_HD constexpr int run_length(const DisparityRange& range) {
    return is_searched_wholly(range) ? kLongRun : kShortRun;
}
inline constexpr std::uint8_t kBeyondRange = 255;
using SearchWindows = Raster<SearchWindow>;
using WindowView = RasterView<const SearchWindow>;

// The costs of the picture's rows first_row .. first_row + rows - 1. Each pixel has the entries of its far
// run, followed by those of its near run.
inline constexpr std::size_t kEntry_bytes = sizeof(std::uint8_t) + sizeof(std::uint16_t);
struct MatchingVolume {
    MatchingVolume(int width_px, int first, int row_count, int run_length)
        : width(width_px),
          first_row(first),
          rows(row_count),
          searched(2 * run_length),
          costs(entries()),
          sums(entries()) {}

    int width, first_row, rows;
    int searched;  // number of disparities of each pixel
    LargeArray<std::uint8_t> costs;
    LargeArray<std::uint16_t> sums;  // sums of the costs of the paths that end at each entry

    std::size_t entries() const { return static_cast<std::size_t>(width) * rows * searched; }
    std::size_t at(int x, int y) const {
        return (static_cast<std::size_t>(y - first_row) * width + x) * static_cast<std::size_t>(searched);
    }
    const std::uint8_t* costs_at(int x, int y) const { return costs.data() + at(x, y); }
    std::uint8_t* costs_at(int x, int y) { return costs.data() + at(x, y); }
    const std::uint16_t* sums_at(int x, int y) const { return sums.data() + at(x, y); }
    std::uint16_t* sums_at(int x, int y) { return sums.data() + at(x, y); }
};

}  // namespace hexrelief::matching
