// Disparities of the sheet's vertices, as mesher/vertex_fit.cpp finds them.
#pragma once

#include "cuda/surface/fit/fit_jacobi_small.cuh"
#include "cuda/surface/fit/fit_initial_planes.cuh"
#include "cuda/surface/fit/fit_jacobi.cuh"
#include "mesher/surface/fit/full_sums_step.h"
#include "mesher/surface/pixels/half_occlusion_step.h"

namespace hexrelief::cuda {

// The normal equations, weighted by how far pixels are from where the vertices begin. Most triangles' follow
// from their moments.
template <typename Crew>
__device__ void gather_sums(const Crew& crew, const SheetState& s, const FitArrays& a, unsigned count,
                            PixelSums& sums) {
    const step::PixelView view = s.view();
    const unsigned warps = crew.threads() / 32;
    unsigned first_now = crew.warp();
    const auto finish = [&](unsigned group, unsigned k, double sum) {
        a.triangles[first_now + group * warps].sums.own[k] = sum;
    };
    step::PlanePatch patch{};  // of the lane's triangle
    each_triangle_pixel(
        crew, s, count,
        [&](unsigned t) {
            const Triangle v = s.sheet.triangles[t];
            const double da = a.values[v[0]], db = a.values[v[1]], dc = a.values[v[2]];
            const Vec2f pa = s.sheet.points[v[0]], pb = s.sheet.points[v[1]], pc = s.sheet.points[v[2]];
            patch = step::plane_patch(pa.x, pa.y, pb.x, pb.y, pc.x, pc.y, da, db, dc);
            const step::Moments moments = a.triangles[t].moments;
            if (a.behind_fall[t] || !step::all_fit(moments, patch)) return true;
            a.triangles[t].sums = step::full_sums(moments, patch);
            return false;
        },
        [&](unsigned group, unsigned, int x, int y, bool is_one, unsigned used) {
            const auto of_group = [&](double value) { return __shfl_sync(~0u, value, group); };
            const step::PlanePatch p{of_group(patch.x),    of_group(patch.y),   of_group(patch.abx),
                                     of_group(patch.aby),  of_group(patch.acx), of_group(patch.acy),
                                     of_group(patch.area), of_group(patch.d0),  of_group(patch.d1),
                                     of_group(patch.d2)};
            step::TriangleSums own;
            if (is_one) {
                const double d = view.disparity[view.index(x, y)];
                double l1, l2;
                const double residual = step::pixel_residual(p, x, y, d, l1, l2), l0 = 1 - l1 - l2;
                const double weight = step::fit_weight(residual, step::is_behind_low_fall(view, x, y));
                step::add_pixel(own, l0, l1, l2, d, weight);
            }
            sums.add(group,
                     {own.own[0], own.own[1], own.own[2], own.mixed[0], own.mixed[1], own.mixed[2],
                      own.right[0], own.right[1], own.right[2]},
                     used, finish);
        },
        [&](unsigned first, unsigned t, bool wanted) {
            const unsigned seen = sums.end_all(finish);
            if (wanted && !(seen >> crew.lane() & 1)) a.triangles[t].sums = {};
            first_now = first + 32 * warps;
        });
}

// Of the kernel's dynamic shared memory: with it the parts' own exceed what is static.
inline constexpr unsigned kFitSharedBytes = PixelSums::kPixels * PixelSums::kSums * sizeof(double);

// Writes s.sheet.disparities. Reads the sheet's points, triangles and origins, pixels and their runs,
// anchors, and of the totals sheet_points, sheet_triangles and farthest_px.
template <typename Crew>
__device__ void fit_disparities(Crew& crew, const SheetState& s, const FitArrays& a) {
    extern __shared__ double pixel_sums[][PixelSums::kSums];
    PixelSums sums(pixel_sums);
    const unsigned points = s.totals->sheet_points, triangles = s.totals->sheet_triangles;
    for (unsigned v = crew.thread(); v < points; v += crew.threads()) {
        a.starts[v] = kCornerRoom * v;
        a.counts[v] = 0;
        FitFlow::clear(a, v);
    }
    find_moments(crew, s, a, triangles, sums);
    crew.wait();
    find_corners(crew, s, a, points, triangles);
    if (crew.any(start_from_planes(crew, s, a, points, sums))) fill_unknown(crew, s, a, points);
    const unsigned lanes = FitFlow::lanes(crew, points);
    gather_sums(crew, s, a, triangles, sums);
    if (lanes > 0) {
        FitFlow flow(crew, s, a, points, lanes);
        crew.wait();
        flow.run();
        crew.wait();
    } else {
        crew.wait();
        relax(crew, s, a, points);
        crew.each(points, [&](unsigned v) { s.sheet.disparities[v] = static_cast<float>(a.values[v]); });
    }
}

}  // namespace hexrelief::cuda
