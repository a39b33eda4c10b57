// Stage: 2D mesh with a disparity at each vertex -> textured, metric surface in space.
#pragma once

#include <vector>

#include "pipeline/data/calibration.h"
#include "pipeline/data/disparity_map.h"
#include "pipeline/data/hex_mesh.h"
#include "pipeline/data/surface_mesh.h"

namespace hexrelief {

struct SurfaceConfig {
    double max_disparity_jump_px = 0;  // triangles whose vertices differ by more are cut; 0 = chosen from the map
    int min_component = 20;            // components of fewer triangles are dropped; 0 = keep all
};

// vertex_disparities: one a lattice vertex, px, +inf where there is no foreground surface.
// image size is that of the map that the mesh was made from. Isolated vertices are dropped, the rest keep lattice order.
// Throws Error(input) where nothing is left to mesh.
SurfaceMesh build_surface(const HexMesh2D& mesh, const std::vector<float>& vertex_disparities,
                          const DisparityMap& map, const Calibration& calibration, const SurfaceConfig& config);

}  // namespace hexrelief
