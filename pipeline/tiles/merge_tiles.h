// Merges a plan's solved tiles into one output.
#pragma once

#include <cstddef>
#include <filesystem>

#include "pipeline/job/log/run_log.h"
#include "pipeline/tiles/tile_plan.h"

namespace hexrelief::tiles {

struct MergedTiles {
    std::size_t tiles = 0, empty = 0;         // of the finest level
    std::size_t vertices = 0, triangles = 0;  // of the finest level
    int levels = 1;
};

// Writes `output`, either a tileset.json of any name, or a .glb of the finest level. Beside the former it
// writes one with implicit tiling ("NAME.implicit.json" and "subtrees/"), and makes the coarser levels that
// are missing, each with a quarter of the triangles of the level below. Throws Error(input) if a tile is not
// solved or an edge between two tiles is not in both, Error(usage) for another extension, Error(output).
MergedTiles merge_tiles(const TilePlan& plan, const std::filesystem::path& output, int threads,
                        job::RunLog& log);

}  // namespace hexrelief::tiles
