// The lattice mesh in the image, cut along depth discontinuities, with a disparity per vertex.
#pragma once

#include <vector>

#include "pipeline/data/geometry.h"
#include "pipeline/data/hex_mesh.h"

namespace hexrelief {

// Vertices are in the order of the lattice vertices that they come from, so that copies of one lattice vertex
// are adjacent in the arrays. Triangles have positive area (x right, y down). An edge has at most two
// triangles, which run through it in opposite directions. A vertex may be non-manifold: several fans of
// triangles touch in it.
struct DisparityMesh {
    std::vector<Vec2f> points;       // px in the left image
    std::vector<float> disparities;  // px, finite
    std::vector<Triangle> triangles;
    // True if each vertex is known to belong to exactly one fan. If false, vertices may even be unused.
    bool has_one_fan_per_vertex = false;
};

}  // namespace hexrelief
