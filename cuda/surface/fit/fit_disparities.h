// Disparities of the mesh's vertices.
#pragma once

#include "cuda/common/arena.h"
#include "cuda/common/launch.h"
#include "cuda/common/surface_state.h"
#include "mesher/surface/fit/fit_disparities_step.h"

namespace hexrelief::cuda {

// Corners of a vertex with an own place for their terms; those beyond are looked up anew.
inline constexpr unsigned kFitSlots = 8;
// Corners that a vertex has capacity for before it is known how many there are.
inline constexpr unsigned kCornerCapacity = 16;

// A vertex' disparity after so many sweeps. Read and written as a whole.
struct alignas(16) FitValue {
    double value;
    unsigned sweeps;
};

// What is known of a triangle: sums of its pixels, then its share of the equations.
union FitTriangle {
    step::Moments moments;
    step::TriangleSums sums;
};

struct FitArrays {
    // Of each vertex: 3 * triangle + corner, ascending.
    unsigned *starts, *counts, *items;
    FitTriangle* triangles;
    unsigned* behind_half_occlusion;      // of triangles: whether a pixel is; their memory holds `next`
    double* around;                       // of vertices: sums of moments, nine each
    double *values, *relaxed;             // disparities of vertices,
    double* planes;                       // those at first
    double* diagonals;                    // of vertices
    double *next_row, *last_row, *right;  // slot * stride + vertex
    unsigned *next, *last;                // the triangle's other vertices
    unsigned stride;
    FitValue* flow[2];  // where a sweep does not wait for all of the one before
};

inline FitArrays take_fit_arrays(const SurfaceSizes& sizes, Arena& arena) {
    const std::size_t points = sizes.most_points, triangles = sizes.most_triangles,
                      slots = kFitSlots * points;
    FitArrays a{};
    for (unsigned** each : {&a.starts, &a.counts}) *each = arena.take<unsigned>(points);
    a.items = arena.take<unsigned>(3 * triangles + kCornerCapacity * points);
    a.triangles = arena.take<FitTriangle>(triangles);
    for (double** each : {&a.values, &a.relaxed, &a.planes, &a.diagonals}) *each = arena.take<double>(points);
    a.around = arena.take<double>(9 * points);
    for (double** each : {&a.next_row, &a.last_row, &a.right}) *each = arena.take<double>(slots);
    for (unsigned** each : {&a.next, &a.last}) *each = arena.take<unsigned>(slots);
    a.behind_half_occlusion = a.next;  // most_triangles <= slots
    a.stride = sizes.most_points;
    for (FitValue*& each : a.flow) each = arena.take<FitValue>(points);
    return a;
}
static_assert(sizeof(FitTriangle) == sizeof(step::Moments));

// As surface::fit_disparities(): writes s.cut_mesh.disparities; reads the rest of s.cut_mesh, the pixels
// and their runs, the anchors and the totals.
void fit_disparities(const Launch& launch, const SurfaceState& s, const FitArrays& a);

}  // namespace hexrelief::cuda
