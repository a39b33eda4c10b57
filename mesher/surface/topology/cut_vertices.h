// Cuts the split lattice apart along its open edges: each vertex fan gets a vertex of its own.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "mesher/surface/topology/cut_vertices_step.h"
#include "mesher/surface/topology/label_triangles.h"
#include "mesher/surface/topology/split_triangles.h"
#include "mesher/surface/topology/triangle_shape_step.h"
#include "pipeline/base/thread_pool.h"
#include "pipeline/data/geometry.h"
#include "pipeline/data/hex_mesh.h"

namespace hexrelief::surface {

// The lattice's triangles on the foreground. Each vertex belongs to a single fan of triangles.
struct CutTriangles {
    std::vector<Vec2f> points;
    std::vector<Triangle> triangles;
    // per triangle its source triangle in the lattice; ascending
    std::vector<std::uint32_t> source_triangles;

    step::MeshTriangles view() const {
        return {static_cast<unsigned>(points.size()), static_cast<unsigned>(triangles.size()),
                triangles.data(), source_triangles.data()};
    }
};

using LatticeFans = step::FanView<const std::array<std::int32_t, 3>*, const std::array<std::uint8_t, 3>*>;

// Returns the view for walking through the fans of the lattice's kept triangles, connected by closed edges.
LatticeFans fans_of(const SplitLattice& lattice, const TriangleLabels& labels);

// Gives each vertex fan a vertex of its own: a copy of its source vertex.
CutTriangles cut_vertices(const SplitLattice& lattice, const TriangleLabels& labels, ThreadPool& pool);

}  // namespace hexrelief::surface
