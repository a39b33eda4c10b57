// The cut mesh of one tile, to the bit the triangles that the undivided lattice would have there, and the
// form in which it is stored.
#pragma once

#include <array>
#include <functional>
#include <vector>

#include "mesher/surface/cut_disparity_mesh.h"
#include "mesher/tiles/lattice_tiles.h"

namespace hexrelief::mesh_tiles {

// px around a tile's block that affect its surface: silhouettes, and holes of up to a lattice cell.
inline constexpr int kTileMargin_px = 64;

struct TileSurfaceInput {
    MapRect window;                     // contains window_of(block, kTileMargin_px)
    const DisparityMap* map = nullptr;  // map of the window, see rounded_disparities()
    float background_px = 0;
    // The whole map's mean area of a lattice cell, and its largest disparity and its smallest one above 0.
    // cut_tile() fills in the other members.
    surface::WholeMap whole;
};

// A corner of a triangle, in coordinates of the whole map.
struct TileCorner {
    Place place;
    float disparity = 0;
    friend auto operator<=>(const TileCorner& a, const TileCorner& b) = default;
};

struct TileSurface {
    DisparityMesh mesh;  // in px of the window
    // Edges between the tile's triangles and those of other tiles, directed as in the tile's own triangles.
    // The other tile has the same edges in the opposite direction.
    std::vector<std::array<TileCorner, 2>> seam_edges;
};

// Rounds disparities to multiples of 1/65536 px, whose sums over pixels are exact at any position.
void rounded_disparities(DisparityMap& map);

// cut_disparity_mesh(), on the CPU or on a device.
using CutMesh =
    std::function<DisparityMesh(const surface::DisparityMeshInput&, const SurfaceConfig&, int threads)>;

// Returns the triangles whose centres lie within the border of tile (i, j), cut from a block that
// TileSolver::tile() solved. Throws what cut_disparity_mesh() throws.
TileSurface cut_tile(const LatticeTiling& tiling, int i, int j, const LatticeBlock& block,
                     const TileSurfaceInput& input, const SurfaceConfig& config, int threads,
                     const CutMesh& cut = surface::cut_disparity_mesh);

// A tile's triangles in integer coordinates of the whole map: the form in which a solved tile is stored.
struct TileMesh {
    std::vector<TileCorner> corners;
    std::vector<Triangle> triangles;                         // their area is positive (x right, y down)
    std::vector<std::array<TileCorner, 2>> seam_edges = {};  // see TileSurface::seam_edges

    bool empty() const { return triangles.empty(); }
};

// Returns the mesh of a surface in px of `window`.
TileMesh tile_mesh_of(const TileSurface& surface, const MapRect& window);

}  // namespace hexrelief::mesh_tiles
