// Joins cuts through the mesh.
#pragma once

#include <cstdint>

#include "cuda/common/arena.h"
#include "cuda/common/launch.h"
#include "cuda/common/surface_state.h"

namespace hexrelief::cuda {

struct CutArrays {
    unsigned* cuts;  // indexed by vertex: number of cut edges at it
    // indexed by vertex: the lowest edge that is still to be checked, combined with its round
    unsigned long long* next_edges[2];
    unsigned* count;
    std::uint32_t* joins;  // edges that may be opened, as 3 * triangle + k
};

inline CutArrays take_cut_arrays(const SurfaceSizes& sizes, Arena& arena) {
    CutArrays a{};
    a.cuts = arena.take<unsigned>(sizes.most_points);
    for (auto& next : a.next_edges) next = arena.take<unsigned long long>(sizes.most_points);
    a.count = arena.take<unsigned>(1);
    a.joins = arena.take<std::uint32_t>(3 * std::size_t{sizes.most_triangles});
    return a;
}

// Does the same as TriangleLabeler::join_cuts(): changes s.labels.open. To be called after open_edges().
// Leaves a.cuts for cut_vertices().
void join_cuts(const Launch& launch, const SurfaceState& s, const CutArrays& a);

}  // namespace hexrelief::cuda
