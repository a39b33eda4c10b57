#include "mesher/tiles/tile_mesh.h"

namespace hexrelief::mesh_tiles {

TileMesh tile_mesh_of(const TileSurface& surface, const MapRect& window) {
    TileMesh mesh{{}, surface.mesh.triangles, surface.seam_edges};
    mesh.corners.reserve(surface.mesh.points.size());
    for (std::size_t v = 0; v < surface.mesh.points.size(); ++v)
        mesh.corners.push_back({place_of(surface.mesh.points[v], window), surface.mesh.disparities[v]});
    return mesh;
}

}  // namespace hexrelief::mesh_tiles
