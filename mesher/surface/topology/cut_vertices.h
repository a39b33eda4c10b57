// Cuts the split lattice open along its open edges: each vertex fan gets a vertex of its own.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "mesher/common/thread_pool.h"
#include "mesher/surface/topology/label_triangles.h"
#include "mesher/surface/topology/split_triangles.h"
#include "mesher/surface/topology/vertex_fans_step.h"
#include "pipeline/data/geometry.h"
#include "pipeline/data/hex_mesh.h"

namespace hexrelief::surface {

// The triangles on the foreground. Each vertex holds one fan of triangles.
struct CutTriangles {
    std::vector<Vec2f> points;
    std::vector<Triangle> triangles;
    std::vector<std::uint32_t> source_triangles;  // a triangle: its number in the lattice; ascending
};

using LatticeFans = step::FanView<const std::array<std::int32_t, 3>*, const std::array<std::uint8_t, 3>*>;

// The fans of the lattice's kept triangles, connected by closed edges.
LatticeFans fans_of(const SplitLattice& lattice, const TriangleLabels& labels);

// Gives each vertex fan a vertex of its own: the same vertex as before, once or several times.
CutTriangles cut_vertices(const SplitLattice& lattice, const TriangleLabels& labels, ThreadPool& pool);

}  // namespace hexrelief::surface
