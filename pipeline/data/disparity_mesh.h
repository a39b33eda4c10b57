// The lattice laid over the scene: opened along depth discontinuities, with a disparity for each vertex.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "pipeline/data/geometry.h"
#include "pipeline/data/hex_mesh.h"

namespace hexrelief {

// Vertices in the order of the lattice they come from, copies of one point side by side. Triangles have
// positive area (x right, y down); every edge has at most two, which run through it in opposite directions. A
// vertex may hold fans of triangles that only touch.
struct DisparityMesh {
    std::vector<Vec2f> points;       // px in the left image
    std::vector<float> disparities;  // px, finite
    std::vector<Triangle> triangles;
    // Vertices that may hold several fans, ascending, where it is known that all others hold one; else any
    // may hold several, or none.
    std::optional<std::vector<std::uint32_t>> non_manifold;
};

}  // namespace hexrelief
