// Fits the disparities of the cut mesh's vertices.
#pragma once

#include "cuda/common/arena.h"
#include "cuda/common/launch.h"
#include "cuda/common/surface_state.h"
#include "mesher/surface/fit/fit_disparities_step.h"

namespace hexrelief::cuda {

// Number of a vertex's corners whose terms are stored; those of further corners are computed again.
inline constexpr unsigned kFitSlots = 8;
// Capacity for a vertex's corners, before their number is known.
inline constexpr unsigned kCornerCapacity = 16;

// A vertex's disparity after `sweeps` sweeps. Read and written as a whole.
struct alignas(16) FitValue {
    double value;
    unsigned sweeps;
};

// The sums of a triangle: first its pixels' moments, then its part of the equations.
union FitTriangle {
    step::Moments moments;
    step::TriangleSums sums;
};

struct FitArrays {
    // Per vertex its corners as 3 * triangle + corner, ascending.
    unsigned *starts, *counts, *items;
    FitTriangle* triangles;
    // per triangle: nonzero if one of its pixels is; uses the memory of `next`
    unsigned* behind_half_occlusion;
    double* around;                       // per vertex: sums of moments, nine each
    double *values, *relaxed;             // per vertex: disparities
    double* planes;                       // per vertex: start values
    double* diagonals;                    // per vertex
    double *next_row, *last_row, *right;  // index: slot * stride + vertex
    unsigned *next, *last;                // the triangle's other vertices
    unsigned stride;
    FitValue* flow[2];  // used if a sweep need not wait for all of the preceding one
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

// Does the same as surface::fit_disparities(): writes s.cut_mesh.disparities. It reads the rest of
// s.cut_mesh, the pixels and their runs, the anchors and the totals.
void fit_disparities(const Launch& launch, const SurfaceState& s, const FitArrays& a);

}  // namespace hexrelief::cuda
