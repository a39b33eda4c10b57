// Start values of the disparities' fit: planes through the pixels around each vertex.
#pragma once

#include "cuda/common/grid_scan.cuh"
#include "cuda/surface/fit/fit_disparities.h"
#include "cuda/surface/fit/triangle_sums.cuh"
#include "mesher/surface/pixels/half_occlusion_step.h"

namespace hexrelief::cuda {

// Sorts the triangles' corners by vertex, ascending.
__device__ inline void find_corners(CooperativeGrid& grid, const SurfaceState& s, const FitArrays& a,
                                    unsigned points, unsigned triangles) {
    const auto put_all = [&](const auto& full) {
        for (unsigned i = grid.thread(); i < 3 * triangles; i += grid.threads()) {
            const unsigned v = s.cut_mesh.triangles[i / 3][i % 3], place = atomicAdd(&a.counts[v], 1);
            if (!full(place)) a.items[a.starts[v] + place] = i;
        }
    };
    bool overflow = false;
    put_all([&](unsigned place) {
        overflow |= place >= kCornerCapacity;
        return place >= kCornerCapacity;
    });
    if (grid.any(overflow)) {
        exclusive_scan(
            grid, points, [&](unsigned v) { return a.counts[v]; },
            [&](unsigned v, unsigned before) { a.starts[v] = before; });
        grid.each(points, [&](unsigned v) { a.counts[v] = 0; });
        put_all([](unsigned) { return false; });
        grid.wait();
    }
    for (unsigned base = 32 * grid.warp(); base < points; base += grid.threads()) {
        const unsigned v = base + grid.lane();
        if (v >= points) continue;
        const unsigned count = a.counts[v];
        unsigned* const items = &a.items[a.starts[v]];
        if (count <= 8) {  // all at once
            unsigned own[8];
#pragma unroll
            for (unsigned i = 0; i < 8; ++i) own[i] = i < count ? items[i] : ~0u;
#pragma unroll
            for (unsigned i = 0; i < 8; ++i) {
                unsigned place = 0;
#pragma unroll
                for (unsigned j = 0; j < 8; ++j) place += own[j] < own[i];
                if (i < count) items[place] = own[i];
            }
            continue;
        }
        for (unsigned i = 1; i < count; ++i) {
            const unsigned item = items[i];
            unsigned at = i;
            for (; at > 0 && items[at - 1] > item; --at) items[at] = items[at - 1];
            items[at] = item;
        }
    }
    grid.wait();
}

// Computes the moments of each triangle's pixels.
__device__ inline void find_moments(const CooperativeGrid& grid, const SurfaceState& s, const FitArrays& a,
                                    unsigned count, PixelSums& sums) {
    const step::PixelView view = s.view();
    const unsigned warps = grid.warps();
    unsigned first_now = grid.warp();
    const auto finish = [&](unsigned group, unsigned k, double sum) {
        (&a.triangles[first_now + group * warps].moments.n)[k] = sum;
    };
    each_triangle_pixel(
        grid, s, count,
        [&](unsigned t) {
            a.behind_half_occlusion[t] = 0;
            return true;
        },
        [&](unsigned group, unsigned t, int x, int y, bool is_one, unsigned used) {
            step::Moments m;
            if (is_one) {
                step::add_pixel(m, x, y, view.disparity[view.index(x, y)]);
                if (step::is_behind_low_half_occlusion(view, x, y)) a.behind_half_occlusion[t] = 1;
            }
            sums.add(group, {m.n, m.x, m.y, m.xx, m.xy, m.yy, m.d, m.xd, m.yd}, used, finish);
        },
        [&](unsigned first, unsigned t, bool wanted) {
            const unsigned seen = sums.end_all(finish);
            if (wanted && !(seen >> grid.lane() & 1))
                for (int k = 0; k < PixelSums::kSums; ++k) (&a.triangles[t].moments.n)[k] = 0;
            first_now = first + 32 * warps;
        });
}

// The moments around vertices, as a warp adds them up.
class VertexMoments {
  public:
    // base: the warp's first vertex; the others, one per lane, are `warps` apart.
    __device__ VertexMoments(const FitArrays& a, PixelSums& sums, unsigned base, unsigned warps)
        : a_(a), sums_(sums), base_(base), warps_(warps) {}

    // Adds a triangle's moments in each of the first `used` lanes; group: the lane to
    // whose vertex they belong.
    __device__ void add(unsigned group, unsigned t, unsigned used) {
        step::Moments m;
        const bool is_one = threadIdx.x % 32 < used;
        if (is_one) m = a_.triangles[t].moments;
        sums_.add(group, {m.n, m.x, m.y, m.xx, m.xy, m.yy, m.d, m.xd, m.yd}, used,
                  [&](unsigned g, unsigned k, double sum) { put(g, k, sum); });
    }
    __device__ void end() {
        sums_.end_all([&](unsigned g, unsigned k, double sum) { put(g, k, sum); });
        __syncwarp();
    }
    __device__ step::Moments of(unsigned v) const {
        step::Moments m;
#pragma unroll
        for (int k = 0; k < PixelSums::kSums; ++k) (&m.n)[k] = a_.around[PixelSums::kSums * v + k];
        return m;
    }

  private:
    __device__ void put(unsigned group, unsigned k, double sum) {
        a_.around[PixelSums::kSums * (base_ + group * warps_) + k] = sum;
    }

    const FitArrays& a_;
    PixelSums& sums_;
    unsigned base_, warps_;
};

// Starts each vertex at the plane through the pixels around it, or without pixels at
// a triangle's own surface.
__device__ inline void start_from_planes(const CooperativeGrid& grid, const SurfaceState& s,
                                         const FitArrays& a, unsigned points, PixelSums& sums) {
    const double floor = step::lowest_disparity(s.totals->farthest_px);
    const unsigned lane = grid.lane(), warps = grid.warps();
    // The warp's next 32 vertices, one per lane.
    for (unsigned base = grid.warp(); base < points; base += 32 * warps) {
        const unsigned mine = base + lane * warps;
        const bool is_mine = mine < points;
        VertexMoments moments(a, sums, base, warps);
        const unsigned start = is_mine ? a.starts[mine] : 0;
        deal_out(is_mine ? a.counts[mine] : 0, [&](unsigned group, unsigned j, bool is_one, unsigned used) {
            const unsigned first = __shfl_sync(~0u, start, group);
            moments.add(group, is_one ? a.items[first + j] / 3 : 0, used);
        });
        moments.end();
        if (!is_mine) continue;
        const step::Moments sum = moments.of(mine);
        const Vec2f at = s.cut_mesh.points[mine];
        const std::uint32_t anchor = s.labels.anchors[s.cut_mesh.source_triangles[a.items[start] / 3]];
        const double begin = sum.n > 0 ? step::plane_at(sum, at.x, at.y) : s.view().disparity[anchor];
        a.values[mine] = a.planes[mine] = step::max_of(floor, begin);
    }
}

}  // namespace hexrelief::cuda
