// Triangles that are lines or turned over after a simplification.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "mesher/tiles/tile_mesh.h"

namespace hexrelief::mesh_tiles {

using SeamEdge = std::array<TileCorner, 2>;

// In the image, in squares of a Place's unit; above 0 where the triangle is not turned over.
std::int64_t twice_area(const TileMesh& mesh, const Triangle& t);

// `triangles` are of some of the mesh's corners. meshoptimizer lets triangles become lines, and turns a few
// over. Such a triangle goes where its long side or both of its short ones are open, or where it stands
// between the two sides of a silhouette; elsewhere that long side is flipped, or else one of its corners
// removed. No seam edge goes. Returns the corners of triangles that are still a line or turned over.
std::vector<std::uint32_t> mend_folds(const TileMesh& mesh, std::vector<Triangle>& triangles);

}  // namespace hexrelief::mesh_tiles
