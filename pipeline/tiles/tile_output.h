// A tile's files.
#pragma once

#include "pipeline/data/image.h"
#include "pipeline/tiles/tile_report.h"
#include "pipeline/tiles/tile_scene.h"

namespace hexrelief::tiles {

// Writes, together, the tile's .mesh, its .glb where it is not empty, and as the last its .json: the report,
// of which the rest is filled in. texture: of the scene's texture coordinates; null = none. `threads` may
// compress at once.
void write_tile(const TilePlan& plan, const TileNumber& tile, const mesh_tiles::TileMesh& mesh,
                const TileScene& scene, const Image* texture, int threads, TileReport report);

// Whether the tile's report is of this plan, and its files are as that says.
bool is_solved(const TilePlan& plan, const TileNumber& tile);

}  // namespace hexrelief::tiles
