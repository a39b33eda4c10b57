// Where the disparities' fit begins: planes through the pixels around each vertex.
#pragma once

#include "cuda/common/grid_scan.cuh"
#include "cuda/surface/fit/fit_disparities.h"
#include "cuda/surface/fit/triangle_sums.cuh"
#include "mesher/surface/pixels/half_occlusion_step.h"

namespace hexrelief::cuda {

// Sorts corners into their vertices.
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

// Of each triangle's pixels.
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
            a.triangles[t].moments.least = step::Moments{}.least;
            a.triangles[t].moments.most = 0;
            a.behind_half_occlusion[t] = 0;
            return true;
        },
        [&](unsigned group, unsigned t, int x, int y, bool is_one, unsigned used) {
            step::Moments m;
            float least = -step::Moments{}.least, most = 0;  // the former with its sign turned
            if (is_one) {
                const float d = view.disparity[view.index(x, y)];
                step::add_pixel(m, x, y, d);
                least = -d;
                most = d;
                if (step::is_behind_low_half_occlusion(view, x, y)) a.behind_half_occlusion[t] = 1;
            }
            sums.add(group, {m.n, m.x, m.y, m.xx, m.xy, m.yy, m.d, m.xd, m.yd}, used, finish);
            if (max_of_group(group, is_one, least, most)) {
                // disparities are positive, and their bits in their order
                step::Moments& all = a.triangles[t].moments;
                atomicMin(reinterpret_cast<int*>(&all.least), __float_as_int(-least));
                atomicMax(reinterpret_cast<int*>(&all.most), __float_as_int(most));
            }
        },
        [&](unsigned first, unsigned t, bool wanted) {
            const unsigned seen = sums.end_all(finish);
            if (wanted && !(seen >> grid.lane() & 1))
                for (int k = 0; k < PixelSums::kSums; ++k) (&a.triangles[t].moments.n)[k] = 0;
            first_now = first + 32 * warps;
        });
}

// Sums of vertices, as a warp adds them up.
class VertexMoments {
  public:
    // base: the warp's first vertex; its others lie `warps` apart, a lane's each.
    __device__ VertexMoments(const FitArrays& a, PixelSums& sums, unsigned base, unsigned warps)
        : a_(a), sums_(sums), base_(base), warps_(warps) {}

    __device__ void begin(unsigned v) {
        a_.least[v] = step::Moments{}.least;
        a_.most[v] = 0;
    }
    // A triangle's, of the first `used` lanes each; group: the lane whose vertex it is for.
    __device__ void add(unsigned group, unsigned t, unsigned used) {
        step::Moments m;
        const bool is_one = threadIdx.x % 32 < used;
        if (is_one) m = a_.triangles[t].moments;
        sums_.add(group, {m.n, m.x, m.y, m.xx, m.xy, m.yy, m.d, m.xd, m.yd}, used,
                  [&](unsigned g, unsigned k, double sum) { put(g, k, sum); });
        float least = -m.least, most = m.most;
        if (max_of_group(group, is_one, least, most)) {
            const unsigned v = base_ + group * warps_;
            atomicMin(reinterpret_cast<int*>(&a_.least[v]), __float_as_int(-least));
            atomicMax(reinterpret_cast<int*>(&a_.most[v]), __float_as_int(most));
        }
    }
    __device__ void end() {
        sums_.end_all([&](unsigned g, unsigned k, double sum) { put(g, k, sum); });
        __syncwarp();
    }
    __device__ step::Moments of(unsigned v) const {
        step::Moments m;
#pragma unroll
        for (int k = 0; k < PixelSums::kSums; ++k) (&m.n)[k] = a_.around[PixelSums::kSums * v + k];
        m.least = a_.least[v];
        m.most = a_.most[v];
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

// Over the triangles at the vertices of the triangles at v, for the group.
__device__ inline void add_second_ring(const SurfaceState& s, const FitArrays& a, unsigned v, unsigned group,
                                       VertexMoments& moments) {
    constexpr unsigned kAtOnce = 10;  // corners; their 30 vertices are looked up side by side
    const unsigned lane = threadIdx.x % 32;
    const unsigned end = a.starts[v] + a.counts[v];
    for (unsigned i = a.starts[v]; i < end; i += kAtOnce) {
        unsigned start = 0, count = 0;
        if (lane < 3 * min(kAtOnce, end - i)) {
            const unsigned u = s.cut_mesh.triangles[a.items[i + lane / 3] / 3][lane % 3];
            start = a.starts[u];
            count = a.counts[u];
        }
        deal_out(count, [&](unsigned from, unsigned j, bool is_one, unsigned used) {
            const unsigned first = __shfl_sync(~0u, start, from);
            moments.add(group, is_one ? a.items[first + j] / 3 : 0, used);
        });
    }
}

// Each vertex at the plane through the pixels around it; returns whether one of the thread's has none.
__device__ inline bool start_from_planes(const CooperativeGrid& grid, const SurfaceState& s,
                                         const FitArrays& a, unsigned points, PixelSums& sums) {
    const double floor = step::lowest_disparity(s.totals->farthest_px);
    const unsigned lane = grid.lane(), warps = grid.warps();
    bool any_unknown = false;
    // A warp's next 32 vertices, one a lane.
    for (unsigned base = grid.warp(); base < points; base += 32 * warps) {
        const unsigned mine = base + lane * warps;
        const bool is_mine = mine < points;
        VertexMoments moments(a, sums, base, warps);
        unsigned start = 0, count = 0;
        Vec2f at{};
        if (is_mine) {
            start = a.starts[mine];
            count = a.counts[mine];
            at = s.cut_mesh.points[mine];
            moments.begin(mine);
            a.longest[mine] = 0;
        }
        __syncwarp();
        deal_out(count, [&](unsigned group, unsigned j, bool is_one, unsigned used) {
            const unsigned first = __shfl_sync(~0u, start, group);
            const Vec2f here{__shfl_sync(~0u, at.x, group), __shfl_sync(~0u, at.y, group)};
            const unsigned t = is_one ? a.items[first + j] / 3 : 0;
            float longest = 0, none = 0;
            if (is_one)
                for (const unsigned u : s.cut_mesh.triangles[t])
                    longest = step::max_of(longest, step::squared_length(here, s.cut_mesh.points[u]));
            if (max_of_group(group, is_one, longest, none))
                atomicMax(reinterpret_cast<int*>(&a.longest[base + group * warps]), __float_as_int(longest));
            moments.add(group, t, used);
        });
        moments.end();
        const bool is_thin = is_mine && !step::holds_plane(moments.of(mine));
        if (is_thin) moments.begin(mine);
        for (unsigned left = __ballot_sync(~0u, is_thin); left != 0; left &= left - 1) {
            const unsigned group = static_cast<unsigned>(__ffs(static_cast<int>(left))) - 1;
            add_second_ring(s, a, base + group * warps, group, moments);
        }
        moments.end();
        if (!is_mine) continue;
        const step::Moments sum = moments.of(mine);
        a.known[mine] = sum.n > 0;
        if (sum.n > 0) {
            const step::FitStart begin = step::fit_start(sum, at, sqrtf(a.longest[mine]), floor);
            a.least[mine] = begin.least;
            a.most[mine] = begin.most;
            a.values[mine] = a.planes[mine] = begin.disparity;
        } else {
            any_unknown = true;
        }
    }
    return any_unknown;
}

// known[v]: the ring in which v became known, from 1 on.
__device__ inline void fill_unknown(CooperativeGrid& grid, const SurfaceState& s, const FitArrays& a,
                                    unsigned points) {
    const auto set = [&](unsigned v, double value) {
        a.values[v] = a.planes[v] = value;
        a.least[v] = a.most[v] = static_cast<float>(value);
    };
    const auto ring_of = [&](unsigned v) { return *const_cast<volatile unsigned*>(&a.known[v]); };
    for (unsigned ring = 1;; ++ring) {
        bool moved = false;
        for (unsigned v = grid.thread(); v < points; v += grid.threads()) {
            if (ring_of(v) != 0) continue;
            double sum = 0;
            int count = 0;
            for (unsigned i = a.starts[v], end = i + a.counts[v]; i < end; ++i)
                for (const unsigned u : s.cut_mesh.triangles[a.items[i] / 3]) {
                    const unsigned known = ring_of(u);
                    if (known != 0 && known <= ring) sum += a.values[u], ++count;
                }
            if (count == 0) continue;
            set(v, sum / count);
            *const_cast<volatile unsigned*>(&a.known[v]) = ring + 1;
            moved = true;
        }
        if (!grid.any(moved)) break;
    }
    const double floor = step::lowest_disparity(s.totals->farthest_px);
    grid.each(points, [&](unsigned v) {
        if (a.known[v] != 0) return;
        const unsigned t = a.items[a.starts[v]] / 3;
        set(v,
            step::max_of(floor, static_cast<double>(
                                    s.view().disparity[s.labels.anchors[s.cut_mesh.source_triangles[t]]])));
    });
}

}  // namespace hexrelief::cuda
