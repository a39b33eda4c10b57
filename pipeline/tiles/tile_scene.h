// A tile in space, on the grid that all tiles share.
#pragma once

#include <array>

#include "mesher/tiles/tile_mesh.h"
#include "pipeline/data/surface_mesh.h"
#include "pipeline/tiles/tile_plan.h"

namespace hexrelief::tiles {

struct TileScene {
    // positions: whole multiples of the plan's grid step from the tile's own origin, exactly; texcoords of
    // the window.
    SurfaceMesh mesh;
    std::array<double, 3> origin_m = {};            // of the tile in space, a multiple of the step
    std::array<double, 3> low_m = {}, high_m = {};  // the tile's box in space
};

// `window` is the part of the picture that the tile is textured with. A corner is at the same place in space
// in every tile, to the bit. Corners that cannot be placed (d + doffs <= 0) are left out with their
// triangles. Throws Error(input) where the tile is too large for the grid.
TileScene tile_scene(const TilePlan& plan, const mesh_tiles::TileMesh& mesh,
                     const mesh_tiles::MapRect& window);

// Drops the components of fewer than min_triangles triangles that no seam edge belongs to: these are whole.
void drop_specks(mesh_tiles::TileMesh& mesh, int min_triangles);

}  // namespace hexrelief::tiles
