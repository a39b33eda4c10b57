// The lattice, cut along depth discontinuities, with a disparity for each vertex.
#pragma once

#include <cstdint>
#include <vector>

#include "pipeline/data/geometry.h"
#include "pipeline/data/hex_mesh.h"

namespace hexrelief {

// Vertices are in the order of the lattice vertices that they come from, so that copies of one point are
// neighbours. Triangles have positive area (x right, y down). An edge has at most two triangles, which run
// through it in opposite directions. A vertex may be non-manifold: several fans of triangles touch there.
struct DisparityMesh {
    std::vector<Vec2f> points;       // px in the left image
    std::vector<float> disparities;  // px, finite
    std::vector<Triangle> triangles;
    // Whether each vertex is known to hold exactly one fan. If not, it may even be unused.
    bool has_one_fan_per_vertex = false;
};

}  // namespace hexrelief
