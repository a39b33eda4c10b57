// Joins cuts through the mesh.
#pragma once

#include "cuda/common/arena.h"
#include "cuda/common/launch.h"
#include "cuda/common/surface_state.h"
#include "mesher/surface/topology/join_cuts_step.h"

namespace hexrelief::cuda {

inline step::CutArrays take_cut_arrays(const SurfaceSizes& sizes, Arena& arena) {
    step::CutArrays a{};
    a.cuts = arena.take<unsigned>(sizes.most_points);
    for (std::uint64_t*& next : a.next_edges) next = arena.take<std::uint64_t>(sizes.most_points);
    a.joins = arena.take<std::uint32_t>(3 * std::size_t{sizes.most_triangles});
    a.count = arena.take<unsigned>(1);
    return a;
}

// Changes s.labels.open. To be called after open_edges(). Leaves a.cuts for cut_vertices().
void join_cuts(const Launch& launch, const SurfaceState& s, const step::CutArrays& a);

}  // namespace hexrelief::cuda
