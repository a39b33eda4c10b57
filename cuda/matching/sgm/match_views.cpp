#include "cuda/matching/sgm/match_views.h"

#include <algorithm>

#include "cuda/matching/sgm/costs.h"
#include "cuda/matching/sgm/paths.h"
#include "pipeline/matching/sgm/sgm.h"

namespace hexrelief::cuda {
namespace {

int kept_rows(int height, int rows) {
    return rows == height ? height : rows - 2 * kBandMargin;
}

}  // namespace

MatchingArrays take_matching_arrays(cudaStream_t stream, Arena& arena, int width, int height, int channels,
                                    int count) {
    MatchingArrays arrays{};
    arrays.pair = take_pair_arrays(stream, arena, width, height, channels);
    const int rows = band_rows(width, height, count), kept = kept_rows(height, rows);
    DeviceVolume& volume = arrays.volume;
    volume.width = width;
    volume.count = count;
    volume.pitch = volume_pitch(count);
    volume.rows = {0, rows};
    volume.kept = {0, kept};
    const std::size_t row_entries = static_cast<std::size_t>(width) * volume.pitch;
    volume.costs = arena.take<std::uint8_t>(row_entries * rows);
    volume.sums = arena.take<std::uint16_t>(row_entries * kept);
    const std::size_t kept_pixels = static_cast<std::size_t>(width) * kept;
    arrays.keys = {arena.take<std::uint32_t>(kept_pixels), arena.take<std::uint32_t>(kept_pixels)};
    return arrays;
}

void match_views(cudaStream_t stream, const MatchingArrays& arrays, int min_px, int p1,
                 const RasterView<std::int16_t>& left, const RasterView<std::int16_t>& right,
                 StageClock& clock) {
    constexpr struct {
        PathDirection direction;
        const char* name;
    } kWalks[] = {{PathDirection::down, "paths down"},
                  {PathDirection::up, "paths up"},
                  {PathDirection::right, "paths to the right"},
                  {PathDirection::left, "paths to the left, keys"}};
    const int height = arrays.pair.height, rows = arrays.volume.rows.count(),
              kept = arrays.volume.kept.count();
    for (int y = 0; y < height; y += kept) {
        DeviceVolume volume = arrays.volume;
        volume.kept = {y, std::min(height, y + kept)};
        volume.rows = volume.kept;
        if (rows < height)
            volume.rows = {std::max(0, y - kBandMargin), std::min(height, volume.kept.end + kBandMargin)};
        find_costs(stream, arrays.pair, min_px, volume);
        clock.ended("costs");
        for (const auto& walk : kWalks) {
            walk_paths(stream, walk.direction, arrays.pair, p1, min_px, volume, arrays.keys);
            clock.ended(walk.name);
        }
        find_winners(stream, volume, arrays.keys, min_px, left, right);
        clock.ended("winners");
    }
}

}  // namespace hexrelief::cuda
