// The fit's linear solver: damped Jacobi sweeps over the vertices.
#pragma once

#include "cuda/surface/fit/fit_disparities.h"
#include "cuda/surface/fit/triangle_sums.cuh"

namespace hexrelief::cuda {

// The data that a sweep needs of one vertex.
struct FitVertex {
    unsigned vertex, start, count;  // start, count: of its corners
    double plane;

    __device__ FitVertex(const FitArrays& a, unsigned v)
        : vertex(v), start(a.starts[v]), count(a.counts[v]), plane(a.planes[v]) {}
};

// The terms of some of a vertex's corners, from corner `first` on, in registers. Those beyond its
// last corner are 0.
template <unsigned kCorners>
struct FitTerms {
    double next_row[kCorners], last_row[kCorners], right[kCorners];
    unsigned next[kCorners], last[kCorners];  // the triangle's other vertices

    // Sets the terms from the triangles' sums and adds their part of the diagonal.
    __device__ void gather(const SurfaceState& s, const FitArrays& a, const FitVertex& v, unsigned first,
                           double& diagonal) {
        unsigned items[kCorners];
#pragma unroll
        for (unsigned j = 0; j < kCorners; ++j)
            items[j] = a.items[v.start + (first + j < v.count ? first + j : 0)];
#pragma unroll
        for (unsigned j = 0; j < kCorners; ++j) {
            const unsigned t = items[j] / 3, k = items[j] % 3;
            const step::CornerRow row = step::corner_row(a.triangles[t].sums, k);
            const bool is_one = first + j < v.count;
            diagonal += is_one ? row.own : 0.0;
            next_row[j] = is_one ? row.next : 0.0;
            last_row[j] = is_one ? row.last : 0.0;
            right[j] = is_one ? row.right : 0.0;
            next[j] = s.cut_mesh.triangles[t][(k + 1) % 3];
            last[j] = s.cut_mesh.triangles[t][(k + 2) % 3];
        }
    }
    __device__ void store(const FitArrays& a, const FitVertex& v, unsigned first) const {
#pragma unroll
        for (unsigned j = 0; j < kCorners; ++j) {
            if (first + j >= v.count) break;
            const unsigned at = (first + j) * a.stride + v.vertex;
            a.next_row[at] = next_row[j];
            a.last_row[at] = last_row[j];
            a.right[at] = right[j];
            a.next[at] = next[j];
            a.last[at] = last[j];
        }
    }
    __device__ void load(const FitArrays& a, const FitVertex& v, unsigned first) {
#pragma unroll
        for (unsigned j = 0; j < kCorners; ++j) {
            const bool is_one = first + j < v.count;
            const unsigned at = (first + j) * a.stride + v.vertex;
            next_row[j] = is_one ? a.next_row[at] : 0.0;
            last_row[j] = is_one ? a.last_row[at] : 0.0;
            right[j] = is_one ? a.right[at] : 0.0;
            next[j] = is_one ? a.next[at] : v.vertex;
            last[j] = is_one ? a.last[at] : v.vertex;
        }
    }
    __device__ void add(const double* values, double& sum) const {
        double nexts[kCorners], lasts[kCorners];
#pragma unroll
        for (unsigned j = 0; j < kCorners; ++j) nexts[j] = values[next[j]], lasts[j] = values[last[j]];
#pragma unroll
        for (unsigned j = 0; j < kCorners; ++j)
            sum += step::right_side({0, next_row[j], last_row[j], right[j]}, nexts[j], lasts[j]);
    }
};

// Makes all sweeps, from a.values to a.values. Each thread keeps the terms of its first vertex in registers;
// those of its other vertices are stored in a's slots in the first sweep.
__device__ inline void relax(const CooperativeGrid& grid, const SurfaceState& s, const FitArrays& a,
                             unsigned points) {
    static_assert(step::kFitSweeps % 2 == 0);
    constexpr unsigned kFew = 4;
    const double floor = step::lowest_disparity(s.totals->farthest_px);
    const unsigned mine = 32 * grid.warp() + grid.lane();
    FitTerms<kFitSlots> kept;
    double diagonal = step::kFitPlaneWeight;
    if (mine < points) {
        const FitVertex v(a, mine);
        kept.gather(s, a, v, 0, diagonal);
        for (unsigned first = kFitSlots; first < v.count; first += kFew) {
            FitTerms<kFew> more;
            more.gather(s, a, v, first, diagonal);
        }
    }
    for (int sweep = 0; sweep < step::kFitSweeps; ++sweep) {
        const double* const values = sweep % 2 == 0 ? a.values : a.relaxed;
        double* const out = sweep % 2 == 0 ? a.relaxed : a.values;
        if (mine < points) {
            const FitVertex v(a, mine);
            double sum = step::kFitPlaneWeight * v.plane, unused = 0;
            kept.add(values, sum);
            for (unsigned first = kFitSlots; first < v.count; first += kFew) {
                FitTerms<kFew> more;
                more.gather(s, a, v, first, unused);
                more.add(values, sum);
            }
            out[mine] = step::relaxed(values[mine], sum, diagonal, floor);
        }
        for (unsigned i = mine + grid.threads(); i < points; i += grid.threads()) {
            const FitVertex v(a, i);
            double sum = step::kFitPlaneWeight * v.plane, all = step::kFitPlaneWeight;
            for (unsigned first = 0; first < v.count; first += kFew) {
                FitTerms<kFew> terms;
                if (sweep == 0 || first >= kFitSlots)
                    terms.gather(s, a, v, first, all);
                else
                    terms.load(a, v, first);
                if (sweep == 0 && first < kFitSlots) terms.store(a, v, first);
                terms.add(values, sum);
            }
            if (sweep == 0) a.diagonals[i] = all;
            out[i] = step::relaxed(values[i], sum, a.diagonals[i], floor);
        }
        grid.wait();
    }
    static_assert(kFitSlots % kFew == 0);
}

}  // namespace hexrelief::cuda
