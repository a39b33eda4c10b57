// The mesh's triangles, vertices and pixels: vertices between surfaces are doubled.
#pragma once

#include <cstdint>

#include "cuda/common/arena.h"
#include "cuda/common/launch.h"
#include "cuda/common/surface_state.h"
#include "cuda/surface/topology/join_cuts.h"
#include "cuda/surface/topology/label_triangles.h"

namespace hexrelief::cuda {

struct FanArrays {
    std::uint32_t* firsts;       // a corner: the first of its fan; kNone where no cut is at its vertex
    std::uint32_t* next;         // a first corner: another one at its vertex
    std::uint32_t* lists;        // a vertex: one of them, kNone = none
    std::uint32_t* fans;         // a vertex: how many
    std::uint32_t* numbers;      // a first corner: its new vertex
    std::uint32_t* wholes;       // a vertex without cuts: its new vertex
    std::uint32_t* runs;         // a triangle: how many
    std::uint32_t* indices;      // a triangle: where it comes in the mesh, behind the new vertices
    std::uint32_t* run_indices;  // a triangle: where its runs come, behind both
    unsigned* behind;            // two: how many new vertices; and triangles of the mesh
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

// As TriangleLabeler::collect_pixels() and surface::cut_vertices(): fills s.cut_mesh but its
// disparities, the runs of s.labels, for which there is run_capacity(), and the totals; after join_cuts().
void cut_vertices(const Launch& launch, const SurfaceState& s, const LabelArrays& labels,
                  const CutArrays& cuts, const FanArrays& a);

}  // namespace hexrelief::cuda
