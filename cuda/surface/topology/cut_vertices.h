// Joins cuts through the mesh, and makes the cut mesh's triangles, vertices and pixels; vertices between
// surfaces are doubled.
#pragma once

#include <cstdint>

#include "cuda/common/arena.h"
#include "cuda/common/launch.h"
#include "cuda/common/surface_state.h"
#include "cuda/surface/topology/label_triangles.h"
#include "mesher/surface/topology/cut_vertices_step.h"
#include "mesher/surface/topology/join_cuts_step.h"

namespace hexrelief::cuda {

struct FanArrays : step::FanArrays {
    std::uint32_t* runs;  // per triangle: the number of its runs
};

inline FanArrays take_fan_arrays(const SurfaceSizes& sizes, Arena& arena) {
    const std::size_t points = sizes.most_points, triangles = sizes.most_triangles;
    const auto words = [&](std::size_t count) { return arena.take<std::uint32_t>(count); };
    FanArrays a{};
    a.firsts = words(3 * triangles);
    a.next = words(3 * triangles);
    a.lists = words(points);
    a.fans = words(points);
    a.numbers = words(points);
    a.copies = words(3 * triangles);
    a.indices = words(triangles);
    a.runs = words(triangles);
    return a;
}

// Fills s.cut_mesh except for its disparities, the runs of s.labels (there is memory for run_capacity() of
// them), as TriangleLabeler::collect_pixels() does, and the totals. To be called after join_cuts().
void cut_vertices(const Launch& launch, const SurfaceState& s, const LabelArrays& labels,
                  const unsigned* cuts, const FanArrays& a);

inline step::CutArrays take_cut_arrays(const SurfaceSizes& sizes, Arena& arena) {
    step::CutArrays a{};
    a.cuts = arena.take<unsigned>(sizes.most_points);
    for (std::uint64_t*& next : a.next_edges) next = arena.take<std::uint64_t>(sizes.most_points);
    a.joins = arena.take<std::uint32_t>(3 * std::size_t{sizes.most_triangles});
    a.count = arena.take<unsigned>(1);
    return a;
}

// Joins cuts through the mesh: changes s.labels.open. To be called after open_edges(). Leaves a.cuts for
// cut_vertices().
void join_cuts(const Launch& launch, const SurfaceState& s, const step::CutArrays& a);

}  // namespace hexrelief::cuda
