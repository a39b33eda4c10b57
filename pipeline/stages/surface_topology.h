// The topology of the surface in space, by OpenMesh: manifoldness, connected components, boundaries.
#pragma once

#include <cstdint>
#include <vector>

#include "pipeline/data/surface_mesh.h"

namespace hexrelief::stages {

// Splits non-manifold vertices: each fan of a vertex (triangles connected through edges at it) gets a vertex
// of its own. Renumbers the triangles in place. Returns the source vertex of each new vertex, ascending;
// vertices without triangles are left out. Precondition: an edge has at most two triangles, which run through
// it in opposite directions.
std::vector<std::uint32_t> split_fans(std::vector<Triangle>& triangles, std::size_t vertex_count);

// Keeps the triangles of the components (connected by edges) with at least `min_triangles`, in their order.
void drop_small_components(std::vector<Triangle>& triangles, std::size_t vertex_count, int min_triangles);

struct Topology {
    int components = 0;  // connected by shared edges or vertices
    int boundary_loops = 0;
};

// Counts components and boundary loops. Throws std::logic_error if the triangles are not manifold.
Topology count_topology(const SurfaceMesh& surface);

}  // namespace hexrelief::stages
