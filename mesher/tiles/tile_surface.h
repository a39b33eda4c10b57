// The cut mesh of one tile: the triangles that the undivided lattice would have there, to the bit.
#pragma once

#include <array>
#include <functional>
#include <vector>

#include "mesher/surface/cut_disparity_mesh.h"
#include "mesher/tiles/lattice_tiles.h"

namespace hexrelief::mesh_tiles {

// px around a tile's block that its surface depends on: silhouettes, holes up to a lattice cell.
inline constexpr int kTileMargin_px = 64;

struct TileSurfaceInput {
    MapRect window;                     // at least window_of(block, kTileMargin_px)
    const DisparityMap* map = nullptr;  // of the window; see rounded_disparities()
    const Image* color = nullptr;       // of the window; null = none
    float background_px = 0;
    // Of the whole map: the area of a lattice cell, the largest and the smallest disparity above 0. The rest
    // is filled in.
    surface::WholeMap whole;
};

// A corner of a triangle, in the whole map.
struct TileCorner {
    Place place;
    float disparity = 0;
    friend auto operator<=>(const TileCorner& a, const TileCorner& b) = default;
};

struct TileSurface {
    DisparityMesh mesh;  // in px of the window
    // Edges between the tile's triangles and those of other tiles, in the direction of the tile's own. The
    // other tile has the same ones, turned round.
    std::vector<std::array<TileCorner, 2>> seam_edges;
};

// Disparities as whole 1/65536 px, whose sums over pixels are exact wherever these lie.
void rounded_disparities(DisparityMap& map);

// cut_disparity_mesh(), on the CPU or on a device.
using CutMesh =
    std::function<DisparityMesh(const surface::DisparityMeshInput&, const SurfaceConfig&, int threads)>;

// Triangles whose centres lie within the border of tile (i, j) of a block that TileSolver::tile() solved.
// Throws as cut_disparity_mesh() does.
TileSurface cut_tile(const LatticeTiling& tiling, int i, int j, const LatticeBlock& block,
                     const TileSurfaceInput& input, const SurfaceConfig& config, int threads,
                     const CutMesh& cut = surface::cut_disparity_mesh);

}  // namespace hexrelief::mesh_tiles
