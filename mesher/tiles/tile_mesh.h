// A tile's triangles in integer coordinates of the whole map: the form in which a solved tile is stored.
#pragma once

#include <array>
#include <vector>

#include "mesher/tiles/tile_surface.h"

namespace hexrelief::mesh_tiles {

struct TileMesh {
    std::vector<TileCorner> corners;
    std::vector<Triangle> triangles;                         // their area is positive (x right, y down)
    std::vector<std::array<TileCorner, 2>> seam_edges = {};  // see TileSurface::seam_edges

    bool empty() const { return triangles.empty(); }
};

// Returns the mesh of a surface in px of `window`.
TileMesh tile_mesh_of(const TileSurface& surface, const MapRect& window);

}  // namespace hexrelief::mesh_tiles
