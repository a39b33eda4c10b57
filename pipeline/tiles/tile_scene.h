// A tile in space, on the grid that all tiles share.
#pragma once

#include <array>

#include "mesher/tiles/tile_mesh.h"
#include "pipeline/data/surface_mesh.h"
#include "pipeline/tiles/tile_plan.h"

namespace hexrelief::tiles {

struct TileScene {
    // positions: exact multiples of the plan's grid step, relative to the tile's own origin;
    // texcoords: within the window.
    SurfaceMesh mesh;
    std::array<double, 3> origin_m = {};            // of the tile in space, a multiple of the step
    std::array<double, 3> low_m = {}, high_m = {};  // bounding box in space
};

// Places a tile in space. `window` is the part of the picture that the tile is textured with. A corner has
// the same position in every tile, to the bit. Corners without a position (d + doffs <= 0) are left out with
// their triangles. Throws Error(input) if the tile is too large for the grid.
TileScene tile_scene(const TilePlan& plan, const mesh_tiles::TileMesh& mesh,
                     const mesh_tiles::MapRect& window);

// Drops components of fewer than min_triangles triangles without seam edges, which are therefore complete.
void drop_specks(mesh_tiles::TileMesh& mesh, int min_triangles);

}  // namespace hexrelief::tiles
