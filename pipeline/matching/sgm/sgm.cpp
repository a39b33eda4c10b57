#include "pipeline/matching/sgm/sgm.h"

#include <algorithm>
#include <cmath>

#include "pipeline/matching/common/rows.h"
#include "pipeline/matching/sgm/paths.h"
#include "pipeline/matching/sgm/window_step.h"

namespace hexrelief {
namespace {

constexpr std::size_t kEntry_bytes = sizeof(std::uint8_t) + sizeof(std::uint16_t);

struct Rows {
    int first, end;
    int count() const { return end - first; }
};

// Rows of a block: as many as fit into block_bytes, or so many that a block takes as much memory as what is
// kept between the blocks, or two a thread where those fit into kLargestVolume_bytes.
int block_rows(int width, Rows band, std::size_t block_bytes, int threads) {
    const auto rows_in = [&](std::size_t bytes) {
        return static_cast<int>(
            std::min<std::size_t>(bytes / (kEntry_bytes * width * kSearched), std::size_t{1} << 30));
    };
    const int balanced = static_cast<int>(std::sqrt(2.0 / 3 * band.count()));
    const int busy = std::min(2 * threads, rows_in(kLargestVolume_bytes));
    return std::min(band.count(), std::max({rows_in(block_bytes), balanced, busy, 1}));
}

// The band's volume is never kept as a whole. On the way down only the vertical paths are followed, and their
// costs kept above each block of rows; on the way up each block's volume is computed from there.
void match_band(const MatchingInput& input, Rows band, Rows kept, std::size_t block_bytes,
                ViewDisparities& views, ThreadPool& pool) {
    const int width = input.left.width();
    const int rows = block_rows(width, band, block_bytes, pool.size());
    const int blocks = (band.count() + rows - 1) / rows;
    MatchingVolume volume(width, band.first, rows);
    PathRows above(blocks, width), below(1, width);
    const auto move_to = [&](int block) {
        volume.first_row = band.first + block * rows;
        volume.rows = std::min(rows, band.end - volume.first_row);
    };
    above.begin(0, band.first);
    for (int block = 0; block + 1 < blocks; ++block) {
        move_to(block);
        descend(input, above.row(block), above.row(block + 1), volume, pool);
    }
    below.begin(0, band.end - 1);
    for (int block = blocks - 1; block >= 0; --block) {
        move_to(block);
        aggregate(input, above.row(block), below.row(0), volume, pool);
        const int first = std::max(kept.first, volume.first_row);
        const int end = std::min(kept.end, volume.first_row + volume.rows);
        if (first < end) find_winners(input, volume, first, end, views, pool);
    }
}

}  // namespace

SearchWindows find_windows(int width, int height, const DisparityRange& range, DisparityView half,
                           ThreadPool& pool) {
    SearchWindows windows(width, height, kWholeWindow);
    const int half_min_px = at_half_size(range).min_px;
    if (range.count > kSearched)
        for_each_row(pool, height, [&](int y) {
            for (int x = 0; x < width; ++x)
                windows.view().at(x, y) = step::find_window(half, half_min_px, range, x, y);
        });
    return windows;
}

int band_rows(int width, int height) {
    const std::size_t row_bytes = kEntry_bytes * static_cast<std::size_t>(width) * kSearched;
    const auto rows = static_cast<int>(std::min<std::size_t>(kLargestVolume_bytes / row_bytes, 1u << 30));
    return std::min(height, std::max(rows, 2 * kBandMargin + 16));
}

ViewDisparities match_views(const ColorPlanes& left, const ColorPlanes& right, const DisparityRange& range,
                            WindowView windows, const step::PathPenalties& penalties, ThreadPool& pool,
                            std::size_t block_bytes) {
    const int width = left.width(), height = left.height();
    ViewDisparities views{Disparities16(width, height, kUnknown16), Disparities16(width, height, kUnknown16)};
    const int rows = band_rows(width, height);
    const int kept = rows == height ? height : rows - 2 * kBandMargin;
    for (int y = 0; y < height; y += kept) {
        const int end = std::min(height, y + kept);
        const Rows band = rows == height
                              ? Rows{0, height}
                              : Rows{std::max(0, y - kBandMargin), std::min(height, end + kBandMargin)};
        match_band({left, right, range, windows, penalties}, band, {y, end}, block_bytes, views, pool);
    }
    return views;
}

}  // namespace hexrelief
