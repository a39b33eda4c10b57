#include "cuda/surface/fit/fit_disparities.h"

#include "cuda/common/grid.cuh"

namespace hexrelief::cuda {
namespace {

__global__ void __launch_bounds__(kGridThreads, 1)
    fit_disparities_kernel(const __grid_constant__ SurfaceState s,
                           const __grid_constant__ step::FitArrays a) {
    if (s.totals->missing_capacity > 0) return;
    CooperativeGrid grid(s.board);
    const auto runs = [&](std::uint32_t t) {
        const std::uint32_t* const start = s.labels.run_starts + t;
        return step::PixelRuns{s.labels.runs + start[0], start[1] - start[0]};
    };
    step::DisparityFitter(grid, s.view(), s.tiles(), s.mesh_triangles(), s.cut_mesh.points, s.labels.anchors,
                          runs, a)
        .fit(step::lowest_disparity(s.totals->farthest_px), s.cut_mesh.disparities);
}

}  // namespace

void fit_disparities(const Launch& launch, const SurfaceState& s, const step::FitArrays& a) {
    launch_cooperative(launch, fit_disparities_kernel, 0, "fitting disparities", s, a);
}

}  // namespace hexrelief::cuda
