// Makes one thing of a plan's solved tiles.
#pragma once

#include <cstddef>
#include <filesystem>

#include "pipeline/job/run_log.h"
#include "pipeline/tiles/tile_plan.h"

namespace hexrelief::tiles {

struct MergedTiles {
    std::size_t tiles = 0, empty = 0;         // of the finest level
    std::size_t vertices = 0, triangles = 0;  // of those
    int levels = 1;
};

// output: tileset.json of any name, with an implicit one beside it ("NAME.implicit.json" and "subtrees/"),
// for which coarser levels are made where they are missing, each of a quarter of the triangles of the one
// below; or .glb, which holds the finest level alone. Throws Error(input) where a tile is not solved, or an
// edge between two tiles is not there in both, Error(usage) for another ending, Error(output).
MergedTiles merge_tiles(const TilePlan& plan, const std::filesystem::path& output, int threads,
                        job::RunLog& log);

}  // namespace hexrelief::tiles
