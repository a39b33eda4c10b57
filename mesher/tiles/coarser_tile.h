// Levels of detail: what some neighbouring tiles show together, with fewer triangles.
#pragma once

#include <functional>
#include <span>

#include "mesher/tiles/tile_mesh.h"

namespace hexrelief::mesh_tiles {

struct CoarserTile {
    // Corners are some of the tiles' own. Its seam edges are those of the tiles that are not between them,
    // and all of these stay edges of its triangles: it fits its neighbours of every level.
    TileMesh mesh;
    // Root mean square differences, in disparity and in depth, between some of the tiles' corners and this
    // surface, where it still has one there.
    double error_px = 0, error_m = 0;
};

// Depth in m of a disparity in px.
using DepthOf = std::function<double(double)>;

// Of the triangles about `share` are left, 0..1: more where seams and silhouettes ask for it. No triangle
// folds over another, and all seam edges stay. Edges are collapsed by meshoptimizer, at the least error as
// quadrics measure it in the image and in disparity (Garland & Heckbert 1997).
TileMesh simplified(const TileMesh& mesh, double share);

// A tile simplified by itself, which can be done as soon as it is there, before coarser_tile(): to more
// triangles than `share` of its own, so that what is held at its seams can be simplified with what is beside
// it.
TileMesh simplified_alone(const TileMesh& tile, double share);

// The tiles' surface with about `share` of their triangles, joined from `parts`: the tiles as
// simplified_alone() leaves them, or as they are.
CoarserTile coarser_tile(std::span<const TileMesh> tiles, std::span<const TileMesh> parts, double share,
                         const DepthOf& depth);

}  // namespace hexrelief::mesh_tiles
