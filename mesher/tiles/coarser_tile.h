// Levels of detail: the surface of some neighbouring tiles with fewer triangles.
#pragma once

#include <functional>
#include <span>

#include "mesher/tiles/tile_surface.h"

namespace hexrelief::mesh_tiles {

struct CoarserTile {
    // Its corners are some of the tiles' corners. Its seam edges are those of the tiles except for the ones
    // between them, and all of these remain edges of its triangles: so it fits its neighbours at every level.
    TileMesh mesh;
    // Root mean square differences in disparity and in depth, measured at some of the tiles' corners at which
    // this surface still has a triangle.
    double error_px = 0, error_m = 0;
};

// Returns the depth in m of a disparity in px.
using DepthOf = std::function<double(double)>;

// Returns the mesh with about `share`, 0..1, of its triangles; more if seams and silhouettes need them. No
// triangle folds over another, and all seam edges stay. Edges are collapsed by meshoptimizer, which minimises
// the quadric error in the image and in disparity (Garland & Heckbert 1997).
TileMesh simplified(const TileMesh& mesh, double share);

// Simplifies a tile by itself, which can be done as soon as the tile exists, before coarser_tile(). It leaves
// more triangles than `share` of them, so that what is held at the tile's seams can later be simplified
// together with its neighbours.
TileMesh simplified_alone(const TileMesh& tile, double share);

// Returns the tiles' surface with about `share` of their triangles, joined from `parts`, the tiles
// with or without simplified_alone().
CoarserTile coarser_tile(std::span<const TileMesh> tiles, std::span<const TileMesh> parts, double share,
                         const DepthOf& depth);

}  // namespace hexrelief::mesh_tiles
