// Mends triangles that are degenerate or turned over after a simplification.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "mesher/tiles/tile_surface.h"

namespace hexrelief::mesh_tiles {

using SeamEdge = std::array<TileCorner, 2>;

// Returns twice the triangle's area in the image, in the square of Place's unit; above 0 if it
// is not turned over.
std::int64_t twice_area(const TileMesh& mesh, const Triangle& t);

// Mends `triangles`, which use some of the mesh's corners. meshoptimizer makes some triangles degenerate
// and turns a few over. Such a triangle is removed if its long side or both of its short sides are open, or
// if it stands upright between the two sides of a silhouette. Otherwise its long side is flipped, or else
// one of its corners is removed. All seam edges stay. Returns the corners of triangles that are still
// degenerate or turned over.
std::vector<std::uint32_t> mend_folds(const TileMesh& mesh, std::vector<Triangle>& triangles);

}  // namespace hexrelief::mesh_tiles
