// Cuts through the mesh that are joined.
#pragma once

#include <cstdint>

#include "cuda/common/arena.h"
#include "cuda/common/launch.h"
#include "cuda/common/surface_state.h"

namespace hexrelief::cuda {

struct CutArrays {
    unsigned* cuts;                     // a vertex: edges of cuts at it
    unsigned long long* next_edges[2];  // a vertex: the lowest edge still to be looked at, with its round
    unsigned* count;
    std::uint32_t* joins;  // edges that may be opened: 3 * triangle + k
};

inline CutArrays take_cut_arrays(const SurfaceSizes& sizes, Arena& arena) {
    CutArrays a{};
    a.cuts = arena.take<unsigned>(sizes.most_points);
    for (auto& next : a.next_edges) next = arena.take<unsigned long long>(sizes.most_points);
    a.count = arena.take<unsigned>(1);
    a.joins = arena.take<std::uint32_t>(3 * std::size_t{sizes.most_triangles});
    return a;
}

// As TriangleLabeler::join_cuts(): changes s.labels.open; after open_edges(). Leaves a.cuts to
// cut_vertices().
void join_cuts(const Launch& launch, const SurfaceState& s, const CutArrays& a);

}  // namespace hexrelief::cuda
