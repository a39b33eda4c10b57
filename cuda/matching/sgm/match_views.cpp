#include "cuda/matching/sgm/match_views.h"

#include <algorithm>

#include "cuda/matching/sgm/paths.h"
#include "pipeline/matching/sgm/sgm.h"

namespace hexrelief::cuda {
namespace {

// Rows that hexrelief::match_views() keeps of a band.
int kept_rows(int width, int height, int count) {
    const int rows = band_rows(width, height, count);
    return rows == height ? height : rows - 2 * kBandMargin;
}

// Rows first .. end - 1 with their margins.
Band band_of(int first, int end, int height, bool whole) {
    if (whole) return {{0, height}, {0, height}};
    return {{std::max(0, first - kBandMargin), std::min(height, end + kBandMargin)}, {first, end}};
}

// Bands of few rows have margins many times as large: then some share their costs.
constexpr int kLeastKeptRows = 128;
int rows_at_once(int kept, int height) {
    return std::min(height, std::max(1, kLeastKeptRows / kept) * kept);
}

}  // namespace

MatchingArrays take_matching_arrays(cudaStream_t stream, Arena& arena, const DeviceColors& colors,
                                    int channels, const DisparityRange& range, int p1) {
    const int count = range.count, width = colors.left.width, height = colors.left.height;
    MatchingArrays arrays{};
    arrays.min_px = range.min_px;
    arrays.p1 = p1;
    arrays.pair = take_pair_arrays(stream, arena, colors, channels);
    arrays.kept_rows = kept_rows(width, height, count);
    const int kept = rows_at_once(arrays.kept_rows, height);
    DeviceVolume& volume = arrays.volume;
    volume.width = width;
    volume.count = count;
    volume.pitch = volume_pitch(count);
    volume.band = band_of(0, kept, height, arrays.one_band());
    const int rows = std::min(height, kept + 2 * kBandMargin);
    volume.costs = arena.take<std::uint8_t>(static_cast<std::size_t>(width) * volume.pitch * rows);
    const std::size_t kept_pixels = static_cast<std::size_t>(width) * kept;
    arrays.keys = {arena.take<std::uint32_t>(kept_pixels), arena.take<std::uint32_t>(kept_pixels)};
    return arrays;
}

void take_sums(Arena& arena, MatchingArrays& arrays) {
    DeviceVolume& volume = arrays.volume;
    volume.sums = arena.take<std::uint16_t>(static_cast<std::size_t>(volume.width) * volume.pitch *
                                            volume.band.kept.count());
}

void match_views(cudaStream_t stream, const MatchingArrays& arrays, const RasterView<std::int16_t>& left,
                 const RasterView<std::int16_t>& right, StageClock& clock) {
    const int height = arrays.pair.height, kept = arrays.kept_rows, at_once = rows_at_once(kept, height);
    for (int y = 0; y < height; y += at_once) {
        const int end = std::min(height, y + at_once);
        DeviceVolume volume = arrays.volume;
        volume.band = band_of(y, end, height, arrays.one_band());
        const PathInput input{arrays.pair, volume, arrays.keys, arrays.p1, arrays.min_px};
        if (!arrays.one_band()) {
            find_costs(stream, arrays.pair, arrays.min_px, volume);
            clock.ended("costs");
        }
        for (const PathDirection direction : {PathDirection::down, PathDirection::up})
            for (int first = y; first < end; first += kept)
                walk_paths(stream, direction, input,
                           band_of(first, std::min(end, first + kept), height, arrays.one_band()));
        clock.ended("vertical paths");
        walk_paths(stream, PathDirection::right, input, volume.band);
        clock.ended("paths to the right");
        walk_paths(stream, PathDirection::left, input, volume.band);
        clock.ended("paths to the left, keys");
        find_winners(stream, volume, arrays.keys, arrays.min_px, left, right);
        clock.ended("winners");
    }
}

}  // namespace hexrelief::cuda
