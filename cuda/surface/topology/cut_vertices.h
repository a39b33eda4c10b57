// The cut mesh's triangles, vertices and pixels; vertices between surfaces are doubled.
#pragma once

#include <cstdint>

#include "cuda/common/arena.h"
#include "cuda/common/launch.h"
#include "cuda/common/surface_state.h"
#include "cuda/surface/topology/join_cuts.h"
#include "cuda/surface/topology/label_triangles.h"

namespace hexrelief::cuda {

struct FanArrays {
    std::uint32_t* firsts;  // per corner: the first corner of its fan; kNone if there is no cut at its vertex
    std::uint32_t* next;    // per first corner: another one at its vertex
    std::uint32_t* lists;   // per vertex: one of its first corners, kNone = none
    std::uint32_t* fans;    // per vertex: the number of its fans
    std::uint32_t* numbers;      // per first corner: its new vertex
    std::uint32_t* wholes;       // per vertex without cuts: its new vertex
    std::uint32_t* runs;         // per triangle: the number of its runs
    std::uint32_t* indices;      // per triangle: its index in the mesh, counted on from the new vertices
    std::uint32_t* run_indices;  // per triangle: the index of its runs, counted on from both
    unsigned* behind;            // two: the number of new vertices; the same plus the mesh's triangles
};

inline FanArrays take_fan_arrays(const SurfaceSizes& sizes, Arena& arena) {
    const std::size_t points = sizes.most_points, triangles = sizes.most_triangles;
    const auto words = [&](std::size_t count) { return arena.take<std::uint32_t>(count); };
    FanArrays a{};
    a.firsts = words(3 * triangles);
    a.next = words(3 * triangles);
    a.lists = words(points);
    a.fans = words(points);
    a.numbers = words(3 * triangles);
    a.wholes = words(points);
    a.runs = words(triangles);
    a.indices = words(triangles);
    a.run_indices = words(triangles);
    a.behind = words(2);
    return a;
}

// Does the same as TriangleLabeler::collect_pixels() and surface::cut_vertices(): fills s.cut_mesh except
// for its disparities, the runs of s.labels (there is memory for run_capacity() of them), and the totals. To
// be called after join_cuts().
void cut_vertices(const Launch& launch, const SurfaceState& s, const LabelArrays& labels,
                  const CutArrays& cuts, const FanArrays& a);

}  // namespace hexrelief::cuda
