// Writes a tile's files.
#pragma once

#include "pipeline/data/image.h"
#include "pipeline/tiles/tile_report.h"
#include "pipeline/tiles/tile_scene.h"

namespace hexrelief::tiles {

// Writes together the tile's .mesh, its .glb unless it is empty, and last its .json, the report,
// whose remaining fields are filled in. texture: that of the scene's texture coordinates; may be
// null. Up to `threads` threads compress.
void write_tile(const TilePlan& plan, const TileNumber& tile, const mesh_tiles::TileMesh& mesh,
                const TileScene& scene, const Image* texture, int threads, TileReport report);

// True if the tile's report belongs to this plan and its files are as the report says.
bool is_solved(const TilePlan& plan, const TileNumber& tile);

}  // namespace hexrelief::tiles
