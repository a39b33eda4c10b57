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

// Of a band with large sums only half of the rows have them at a time: half as many horizontal paths still
// keep a device busy. Whole segments of the vertical paths.
constexpr std::size_t kLargeSums_bytes = std::size_t{512} << 20;
int rows_with_sums(const DeviceVolume& volume, int kept, int at_once) {
    const std::size_t row_bytes = sizeof(std::uint16_t) * volume.width * volume.pitch;
    if (kept < at_once || at_once * row_bytes <= kLargeSums_bytes) return at_once;
    const int steps = segment_steps(volume.count);
    return ((at_once + 1) / 2 + steps - 1) / steps * steps;
}

int segments_of(const DeviceVolume& volume, int pixels) {
    const int steps = segment_steps(volume.count);
    return (pixels + steps - 1) / steps;
}

// Entries of the costs before a row's segments.
std::size_t row_of_segments(const DeviceVolume& volume) {
    return static_cast<std::size_t>(segments_of(volume, volume.width)) * volume.pitch;
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
    volume.lane_count = disparities_a_lane(count);
    volume.pitch = (count + volume.lane_count - 1) / volume.lane_count * volume.lane_count;
    volume.band = band_of(0, kept, height, arrays.one_band());
    const int rows = std::min(height, kept + 2 * kBandMargin);
    volume.costs = arena.take<std::uint8_t>(static_cast<std::size_t>(width) * volume.pitch * rows);
    arrays.sum_rows = rows_with_sums(volume, arrays.kept_rows, kept);
    const std::size_t kept_pixels = static_cast<std::size_t>(width) * arrays.sum_rows;
    arrays.keys = {arena.take<std::uint32_t>(kept_pixels), arena.take<std::uint32_t>(kept_pixels)};
    return arrays;
}

void take_sums(Arena& arena, MatchingArrays& arrays) {
    DeviceVolume& volume = arrays.volume;
    const std::size_t row = static_cast<std::size_t>(volume.width) * volume.pitch;
    const int bands = (volume.band.kept.count() + arrays.kept_rows - 1) / arrays.kept_rows;
    volume.sums = arena.take<std::uint16_t>(row * arrays.sum_rows);
    arrays.paths.before_rows = arena.take<std::uint16_t>(
        row * bands * segments_of(volume, std::min(volume.band.kept.count(), arrays.kept_rows)));
    arrays.paths.before_columns =
        arena.take<std::uint16_t>(row_of_segments(volume) * volume.band.kept.count());
    arrays.paths.below = arena.take<std::uint16_t>(row);
}

void match_views(cudaStream_t stream, const MatchingArrays& arrays, const RasterView<std::int16_t>& left,
                 const RasterView<std::int16_t>& right, StageClock& clock) {
    const int height = arrays.pair.height, kept = arrays.kept_rows, at_once = rows_at_once(kept, height);
    const std::size_t row = static_cast<std::size_t>(arrays.volume.width) * arrays.volume.pitch;
    for (int y = 0; y < height; y += at_once) {
        const int end = std::min(height, y + at_once);
        PathInput input{arrays.pair, arrays.volume, arrays.keys, arrays.p1, arrays.min_px};
        DeviceVolume& volume = input.volume;
        volume.band = band_of(y, end, height, arrays.one_band());
        if (!arrays.one_band()) {
            find_costs(stream, arrays.pair, arrays.min_px, volume);
            clock.ended("costs");
        }
        const auto band_from = [&](int first) {
            return band_of(first, std::min(end, first + kept), height, arrays.one_band());
        };
        const auto before_rows = [&](int first) {
            const int band = (first - y) / kept;
            return arrays.paths.before_rows +
                   row * (band * segments_of(volume, kept) + segments_of(volume, first - y - band * kept));
        };
        for (int first = y; first < end; first += kept)
            walk_down(stream, input, band_from(first), before_rows(first));
        clock.ended("paths down");
        walk_right(stream, input, {y, end}, arrays.paths.before_columns);
        clock.ended("paths to the right");
        // From below: the rows whose sums are kept at a time are some of a band's, or those of some bands.
        for (int sums_end = end; sums_end > y; sums_end = volume.band.kept.first) {
            const int parts = (sums_end - y + arrays.sum_rows - 1) / arrays.sum_rows;
            volume.band.kept = {y + (parts - 1) * arrays.sum_rows, sums_end};
            for (int first = volume.band.kept.first; first < sums_end; first += kept)
                walk_up(stream, input, band_from(first - (first - y) % kept),
                        {first, std::min(sums_end, first + kept)}, before_rows(first), arrays.paths.below);
            clock.ended("paths up");
            walk_left(stream, input,
                      arrays.paths.before_columns + row_of_segments(volume) * (volume.band.kept.first - y));
            clock.ended("paths to the left, keys");
            find_winners(stream, volume, arrays.keys, arrays.min_px, left, right);
            clock.ended("winners");
        }
    }
}

}  // namespace hexrelief::cuda
