#include "cuda/matching/sgm/match_views.h"

#include "cuda/matching/sgm/costs.h"
#include "cuda/matching/sgm/paths.h"
#include "cuda/matching/sgm/windows.h"
#include "cuda/matching/sgm/winners.h"

namespace hexrelief::cuda {

void match_views(cudaStream_t stream, Arena& arena, const PairArrays& pair, const DisparityRange& range,
                 int p1, const RasterView<std::int16_t>& half, const RasterView<std::int16_t>& left,
                 const RasterView<std::int16_t>& right, StageClock& clock) {
    const Arena::Mark before = arena.mark();
    const int width = pair.width, height = pair.height, rows = band_rows(width, height);
    const RasterView<SearchWindow> windows = take_plain_raster<SearchWindow>(arena, width, height);
    find_windows(stream, half, range, windows);
    clock.ended("windows");
    const std::size_t pixels = static_cast<std::size_t>(width) * rows, entries = pixels * kSearched;
    DeviceVolume volume{};
    volume.width = width;
    volume.count = range.count;
    volume.windows = reading(windows);
    volume.costs = arena.take<std::uint8_t>(entries);
    volume.sums = volume.sums_of_rows = arena.take<std::uint16_t>(entries);
    volume.sums_of_columns = arena.take<std::uint16_t>(entries);
    const KeptCosts kept_costs = take_kept_costs(arena, width, rows);
    std::uint32_t* const right_keys = arena.take<std::uint32_t>(pixels);
    for (const Band& band : bands_of(width, height)) {
        volume.band = band;
        find_costs(stream, pair, range.min_px, volume);
        clock.ended("costs");
        walk_paths(stream, pair, volume, p1, kept_costs);
        clock.ended("paths");
        find_winners(stream, volume, right_keys, range.min_px, left, right);
        clock.ended("winners");
    }
    arena.release(before);
}

}  // namespace hexrelief::cuda
