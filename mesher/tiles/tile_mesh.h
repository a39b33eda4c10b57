// A tile's triangles by themselves, in whole numbers of the whole map: what is kept of a solved tile.
#pragma once

#include <array>
#include <vector>

#include "mesher/tiles/tile_surface.h"

namespace hexrelief::mesh_tiles {

struct TileMesh {
    std::vector<TileCorner> corners;
    std::vector<Triangle> triangles;                         // of positive area (x right, y down)
    std::vector<std::array<TileCorner, 2>> seam_edges = {};  // see TileSurface

    bool empty() const { return triangles.empty(); }
};

TileMesh tile_mesh_of(const TileSurface& surface, const MapRect& window);

}  // namespace hexrelief::mesh_tiles
