// The cut mesh's triangles, vertices and pixels; vertices between surfaces are doubled.
#pragma once

#include <cstdint>

#include "cuda/common/arena.h"
#include "cuda/common/launch.h"
#include "cuda/common/surface_state.h"
#include "cuda/surface/topology/label_triangles.h"
#include "mesher/surface/topology/cut_vertices_step.h"

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

}  // namespace hexrelief::cuda
