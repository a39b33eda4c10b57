// Goes through the pixels of the mesh's triangles by warps, and adds up numbers over them in order.
#pragma once

#include "cuda/common/grid.cuh"
#include "cuda/common/surface_state.h"
#include "cuda/common/warp_reduce.cuh"

namespace hexrelief::cuda {

// Ordered sums of nine numbers per pixel over the pixels of each of a warp's triangles, one after the other.
class PixelSums {
  public:
    static constexpr int kSums = 9;
    static constexpr unsigned kPixels = 256;  // of all warps at a time: 18 KB of a block's shared memory

    // scratch: shared by the block.
    __device__ explicit PixelSums(double (*scratch)[kSums])
        : at_once_(min(32u, kPixels / (kGridWarps) / 8 * 8)),
          scratch_(scratch + threadIdx.x / 32 * at_once_) {}

    // Adds the numbers of the first `used` lanes in order. group: index of the lane's triangle, below 32 and
    // ascending. finish(group, k, sum) is called by lane k < kSums for each triangle that is complete.
    template <typename Finish>
    __device__ void add(unsigned group, const double (&mine)[kSums], unsigned used, const Finish& finish) {
        const unsigned lane = threadIdx.x % 32, before = __shfl_up_sync(~0u, group, 1),
                       heads = __ballot_sync(~0u, lane < used && group != (lane > 0 ? before : group_));
        for (unsigned first = 0; first < used; first += at_once_) {
            __syncwarp();
            if (lane >= first && lane < first + at_once_) {
#pragma unroll
                for (int k = 0; k < kSums; ++k) scratch_[lane - first][k] = lane < used ? mine[k] : 0.0;
            }
            __syncwarp();
            const unsigned k = min(lane, kSums - 1u);
            for (unsigned i = 0; i < at_once_; i += 8) {
                double more[8];
#pragma unroll
                for (unsigned j = 0; j < 8; ++j) more[j] = scratch_[i + j][k];
                if ((heads >> (first + i) & 0xff) == 0) {
#pragma unroll
                    for (unsigned j = 0; j < 8; ++j) sum_ += more[j];
                    continue;
                }
#pragma unroll
                for (unsigned j = 0; j < 8; ++j) {
                    if (heads >> (first + i + j) & 1) {
                        end(finish);
                        group_ = __shfl_sync(~0u, group, first + i + j);
                    }
                    sum_ += more[j];
                }
            }
        }
    }
    // Finishes the last triangle; returns a bit for each triangle that had pixels.
    template <typename Finish>
    __device__ unsigned end_all(const Finish& finish) {
        end(finish);
        group_ = kNone;
        const unsigned all = ended_;
        ended_ = 0;
        return all;
    }

  private:
    static constexpr unsigned kNone = 32;

    template <typename Finish>
    __device__ void end(const Finish& finish) {
        if (group_ == kNone) return;
        if (threadIdx.x % 32 < kSums) finish(group_, threadIdx.x % 32, sum_);
        ended_ |= 1u << group_;
        sum_ = 0;
    }

    unsigned at_once_;  // a multiple of 8
    double (*scratch_)[kSums];
    double sum_ = 0;
    unsigned group_ = kNone, ended_ = 0;
};

// Distributes the items of the lanes, of which each has `mine`: calls visit(owner's lane, index among its
// items, whether there is one, number of lanes used) for all items in order, 32 at a time.
template <typename Visit>
__device__ void deal_out(unsigned mine, const Visit& visit) {
    // End of the lane's items in the order of all.
    const unsigned lane = threadIdx.x % 32, end = sum_up_to_lane(mine);
    const unsigned all = __shfl_sync(~0u, end, 31), start = end - mine;
    for (unsigned first = 0; first < all; first += 32) {
        const unsigned item = first + lane;
        unsigned from = 0;  // number of lanes whose items end at or before it
#pragma unroll
        for (unsigned step = 16; step > 0; step /= 2)
            if (__shfl_sync(~0u, end, from + step - 1) <= item) from += step;
        visit(from, item - __shfl_sync(~0u, start, from), item < all, min(32u, all - first));
    }
}

// Goes through a warp's triangles, 32 at a time, one per lane, `warps` apart. Calls begin(t), which returns
// true if the triangle's pixels are wanted; then, by all lanes together, visit(lane of the triangle,
// triangle, x, y, whether there is one, number of lanes used) for these pixels in order; then end(triangle of
// lane 0, own triangle, whether it was wanted).
template <typename Begin, typename Visit, typename End>
__device__ void each_triangle_pixel(const CooperativeGrid& grid, const SurfaceState& s, unsigned count,
                                    const Begin& begin, const Visit& visit, const End& end) {
    const unsigned lane = grid.lane(), warps = grid.warps();
    for (unsigned base = grid.warp(); base < count; base += 32 * warps) {
        const unsigned mine = base + lane * warps;
        const bool wanted = mine < count && begin(mine);
        unsigned first = 0, runs = 0;
        if (wanted) {
            const unsigned* const start = &s.labels.run_starts[s.cut_mesh.source_triangles[mine]];
            first = start[0];
            runs = start[1] - first;
        }
        __syncwarp();
        deal_out(runs, [&](unsigned group, unsigned i, bool is_run, unsigned) {
            const unsigned at = __shfl_sync(~0u, first, group) + i;
            const surface::PixelRun run = is_run ? s.labels.runs[at] : surface::PixelRun{};
            deal_out(static_cast<unsigned>(run.end - run.first),
                     [&](unsigned from, unsigned j, bool is_one, unsigned used) {
                         const int x = __shfl_sync(~0u, run.first, from) + static_cast<int>(j),
                                   y = __shfl_sync(~0u, run.y, from);
                         const unsigned own = __shfl_sync(~0u, group, from);
                         visit(own, base + own * warps, x, y, is_one, used);
                     });
        });
        end(base, mine, wanted);
    }
}

}  // namespace hexrelief::cuda
