// The halfedge side of the surface stage: manifoldness, components, boundaries (OpenMesh).
#pragma once

#include <cstdint>
#include <vector>

#include "pipeline/data/surface_mesh.h"

namespace hexrelief {

// Gives every fan of triangles around a vertex a vertex of its own: a fan is what hangs together through
// edges at that vertex. Triangles are renumbered in place; returns for each new vertex the old one, in
// ascending order, unused ones left out. Precondition: every edge has at most two triangles, which run
// through it in opposite directions.
std::vector<std::uint32_t> split_fans(std::vector<Triangle>& triangles, std::size_t vertex_count);
// The same where all vertices but these, ascending, are known to hold one fan; these hold at least one.
std::vector<std::uint32_t> split_fans(std::vector<Triangle>& triangles, std::size_t vertex_count,
                                      const std::vector<std::uint32_t>& non_manifold);

// Keeps the triangles of components (connected by edges) with at least `min_triangles`, in order.
void drop_small_components(std::vector<Triangle>& triangles, std::size_t vertex_count, int min_triangles);

struct Topology {
    int components = 0;  // connected by shared edges or vertices
    int boundary_loops = 0;
};

// Of a mesh whose triangles are manifold. Throws std::logic_error otherwise.
Topology count_topology(const SurfaceMesh& surface);

}  // namespace hexrelief
