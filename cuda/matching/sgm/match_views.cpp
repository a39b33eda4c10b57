#include "cuda/matching/sgm/match_views.h"

#include "cuda/matching/sgm/paths.h"

namespace hexrelief::cuda {

void match_views(Workspace& work, const PairArrays& pair, const SearchConfig& config,
                 const matching::RasterView<std::int16_t>& half, const DeviceViews& views) {
    const cudaStream_t stream = work.stream;
    Arena& arena = work.arena;
    const Arena::Mark before = arena.mark();
    const int width = pair.width, height = pair.height, rows = matching::band_rows(width, height);
    DeviceVolume volume{};
    volume.width = width;
    volume.range = config.range;
    volume.pixels = take_path_pixels(arena, width, height);
    find_path_pixels(stream, reading(pair.colors[0]), half, config.range, config.penalties, volume.pixels);
    const int searched = 2 * run_length(volume.range);
    const std::size_t pixels = static_cast<std::size_t>(width) * rows, entries = pixels * searched;
    volume.costs = arena.take<std::uint8_t>(entries);
    volume.sums_of_rows = arena.take<std::uint16_t>(entries);
    volume.sums_of_columns = arena.take<std::uint16_t>(entries);
    const KeptCosts kept_costs = take_kept_costs(arena, width, rows, searched);
    volume.right_best = views.right.origin ? arena.take<RightBest>(pixels) : nullptr;
    for (const matching::Band& band : matching::bands_of(width, height)) {
        volume.band = band;
        find_costs(stream, pair, volume);
        walk_paths(stream, volume, config.penalties.p1, kept_costs);
        find_winners(stream, volume, views.left, views.right);
    }
    arena.release(before);
}

}  // namespace hexrelief::cuda
