// Levels of detail: what some neighbouring tiles show together, with fewer triangles.
#pragma once

#include <functional>
#include <span>

#include "mesher/tiles/tile_mesh.h"

namespace hexrelief {

struct CoarserTile {
    // Corners are some of the tiles' own. Its seam edges are those of the tiles that are not between them,
    // and all of these stay edges of its triangles: it fits its neighbours of every level.
    TileMesh mesh;
    // Root mean square differences, in disparity and in depth, between the tiles' corners and this surface,
    // where it still has one there.
    double error_px = 0, error_m = 0;
};

// Depth in m of a disparity in px.
using DepthOf = std::function<double(double)>;

// Of the tiles' triangles about `share` are left, 0..1: more where seams and silhouettes ask for it. No
// triangle folds over another. Edges are collapsed by meshoptimizer, at the least error as quadrics measure
// it in the image and in disparity (Garland & Heckbert 1997). The outcome is the same for any number of
// threads.
CoarserTile coarser_tile(std::span<const TileMesh> tiles, double share, const DepthOf& depth,
                         int threads = 1);

}  // namespace hexrelief
