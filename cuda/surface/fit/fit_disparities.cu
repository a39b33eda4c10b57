#include "cuda/surface/fit/fit_disparities.h"

#include "cuda/common/grid.cuh"
#include "cuda/surface/fit/fit_initial_planes.cuh"
#include "cuda/surface/fit/fit_jacobi.cuh"
#include "cuda/surface/fit/fit_jacobi_small.cuh"
#include "mesher/surface/fit/full_sums_step.h"
#include "mesher/surface/pixels/half_occlusion_step.h"

namespace hexrelief::cuda {
namespace {

// Sets up each triangle's normal equations; those of most triangles follow from their moments.
__device__ void gather_sums(const CooperativeGrid& grid, const SurfaceState& s, const FitArrays& a,
                            unsigned count, PixelSums& sums) {
    const step::PixelView view = s.view();
    const unsigned warps = grid.warps();
    unsigned first_now = grid.warp();
    const auto finish = [&](unsigned group, unsigned k, double sum) {
        a.triangles[first_now + group * warps].sums.own[k] = sum;
    };
    step::PlanePatch patch{};  // of the lane's triangle
    each_triangle_pixel(
        grid, s, count,
        [&](unsigned t) {
            const Triangle v = s.cut_mesh.triangles[t];
            const Vec2f pa = s.cut_mesh.points[v[0]], pb = s.cut_mesh.points[v[1]],
                        pc = s.cut_mesh.points[v[2]];
            patch = step::plane_patch(pa.x, pa.y, pb.x, pb.y, pc.x, pc.y);
            if (a.behind_half_occlusion[t] || !step::holds_sums(patch)) return true;
            const step::Moments moments = a.triangles[t].moments;
            a.triangles[t].sums = step::full_sums(moments, patch);
            return false;
        },
        [&](unsigned group, unsigned, int x, int y, bool is_one, unsigned used) {
            const auto of_group = [&](double value) { return __shfl_sync(~0u, value, group); };
            const step::PlanePatch p{of_group(patch.x),   of_group(patch.y),   of_group(patch.abx),
                                     of_group(patch.aby), of_group(patch.acx), of_group(patch.acy),
                                     of_group(patch.area)};
            step::TriangleSums own;
            if (is_one) {
                const double d = view.disparity[view.index(x, y)];
                double l1, l2;
                step::pixel_shares(p, x, y, l1, l2);
                step::add_pixel(own, 1 - l1 - l2, l1, l2, d, step::fit_weight(view, x, y));
            }
            sums.add(group,
                     {own.own[0], own.own[1], own.own[2], own.cross[0], own.cross[1], own.cross[2],
                      own.right[0], own.right[1], own.right[2]},
                     used, finish);
        },
        [&](unsigned first, unsigned t, bool wanted) {
            const unsigned seen = sums.end_all(finish);
            if (wanted && !(seen >> grid.lane() & 1)) a.triangles[t].sums = {};
            first_now = first + 32 * warps;
        });
}

// Writes s.cut_mesh.disparities. Reads the rest of s.cut_mesh, the pixels and their runs, the anchors, and
// mesh_points, mesh_triangles and farthest_px of the totals.
__device__ void fit_disparities(CooperativeGrid& grid, const SurfaceState& s, const FitArrays& a) {
    __shared__ double pixel_sums[PixelSums::kPixels][PixelSums::kSums];
    PixelSums sums(pixel_sums);
    const unsigned points = s.totals->mesh_points, triangles = s.totals->mesh_triangles;
    for (unsigned v = grid.thread(); v < points; v += grid.threads()) {
        a.starts[v] = kCornerCapacity * v;
        a.counts[v] = 0;
        FitFlow::clear(a, v);
    }
    find_moments(grid, s, a, triangles, sums);
    grid.wait();
    find_corners(grid, s, a, points, triangles);
    start_from_planes(grid, s, a, points, sums);
    grid.wait();
    const unsigned lanes = FitFlow::lanes(grid, points);
    gather_sums(grid, s, a, triangles, sums);
    if (lanes > 0) {
        FitFlow flow(grid, s, a, points, lanes);
        grid.wait();
        flow.run();
        grid.wait();
    } else {
        grid.wait();
        relax(grid, s, a, points);
        grid.each(points, [&](unsigned v) { s.cut_mesh.disparities[v] = static_cast<float>(a.values[v]); });
    }
}

__global__ void __launch_bounds__(kGridThreads, 1)
    fit_disparities_kernel(const __grid_constant__ SurfaceState s, const __grid_constant__ FitArrays a) {
    if (s.totals->missing_capacity > 0) return;
    CooperativeGrid grid(s.board);
    fit_disparities(grid, s, a);
}

}  // namespace

void fit_disparities(const Launch& launch, const SurfaceState& s, const FitArrays& a) {
    launch_cooperative(launch, fit_disparities_kernel, 0, "fitting disparities", s, a);
}

}  // namespace hexrelief::cuda
