// Fits the disparities of the cut mesh's vertices.
#pragma once

#include "cuda/common/arena.h"
#include "cuda/common/launch.h"
#include "cuda/common/surface_state.h"
#include "mesher/surface/fit/disparity_fitter_step.h"

namespace hexrelief::cuda {

inline step::FitArrays take_fit_arrays(const SurfaceSizes& sizes, Arena& arena) {
    const std::size_t points = sizes.most_points, triangles = sizes.most_triangles;
    step::FitArrays a{};
    a.corners = {arena.take<unsigned>(points), arena.take<unsigned>(points),
                 arena.take<std::uint32_t>(3 * triangles)};
    a.triangles = arena.take<step::FitTriangle>(triangles);
    a.terms = arena.take<step::FitTerm>(3 * triangles);
    a.equations = arena.take<step::FitEquation>(points);
    for (double*& each : a.values) each = arena.take<double>(points);
    return a;
}

// Does the same as surface::fit_disparities(): writes s.cut_mesh.disparities. It reads the rest of
// s.cut_mesh, the pixels and their runs, the anchors and the totals.
void fit_disparities(const Launch& launch, const SurfaceState& s, const step::FitArrays& a);

}  // namespace hexrelief::cuda
