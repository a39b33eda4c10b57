// The pieces of a triangle by a warp, as TrianglePieces finds them: pixels that hang together.
#pragma once

#include <cstdint>

#include "cuda/triangle_warp.cuh"
#include "mesher/steps/triangle_sides.h"

namespace hexrelief::cuda {

// Pieces are disjoint sets of pixels that lead to lower ones, the lowest of each leading to itself; triangles
// of few pixels have them in shared memory.
class WarpPieces {
  public:
    // room: where nothing else is written, for the pixels of the triangle, twice; by its warp alone.
    __device__ WarpPieces(const step::PixelView& view, TriangleWarp& pixels, unsigned count, unsigned* room)
        : view_(view),
          pixels_(pixels),
          count_(count),
          lane_(threadIdx.x % 32),
          parents_(room),
          areas_(room + count) {}

    // Finds them and the largest, the first of equal ones.
    __device__ void find() {
        begin();
        __syncwarp();
        pixels_.each_rows([&](const LaneRows& rows) {
            pixels_.each_pixel(rows, [&](const LanePixel& p) { join_upper(rows, p); });
            if (rows.own && rows.has_upper) join_rows(rows);
        });
        __syncwarp();
        measure();
        __syncwarp();
        choose();
    }
    __device__ bool is_largest(unsigned pixel) const { return parents_[pixel] == largest_; }
    __device__ unsigned largest() const { return largest_; }  // its first pixel
    __device__ unsigned area() const { return area_; }        // of the largest

  private:
    __device__ bool is_free(std::uint32_t index, std::uint8_t jump) const {
        return !(view_.flags[index] & jump);
    }
    // Pixels of a row without a jump between them lead to the first of them.
    __device__ void begin() {
        unsigned last = 0;
        pixels_.each_rows([&](const LaneRows& rows) {
            pixels_.each_pixel(rows, [&](const LanePixel& p) {
                const bool begins = p.valid && (p.x == p.first || !is_free(p.index - 1, step::kJumpRight));
                const unsigned begin = __ballot_sync(kAllLanes, begins) & ((2u << lane_) - 1);
                const unsigned start = begin ? p.k - lane_ + 31 - __clz(begin) : last;
                if (p.valid) {
                    parents_[p.k] = start;
                    areas_[p.k] = 0;
                }
                last = __shfl_sync(kAllLanes, start, 31);
            });
        });
    }
    __device__ unsigned root(unsigned i) const {
        const volatile unsigned* const parents = parents_;
        for (unsigned parent = parents[i]; parent != i; parent = parents[i]) i = parent;
        return i;
    }
    __device__ void join(unsigned i, unsigned j) {
        for (;;) {
            i = root(i);
            j = root(j);
            if (i == j) return;
            const unsigned low = min(i, j), high = max(i, j);
            if (atomicCAS(&parents_[high], high, low) == high) return;
        }
    }
    // With the pixel above, unless those to the left of both have told already.
    __device__ void join_upper(const LaneRows& rows, const LanePixel& p) {
        const PixelRun upper{__shfl_sync(kAllLanes, rows.upper.y, p.row),
                             __shfl_sync(kAllLanes, rows.upper.first, p.row),
                             __shfl_sync(kAllLanes, rows.upper.end, p.row)};
        const unsigned upper_before = __shfl_sync(kAllLanes, rows.upper_before, p.row);
        const bool has_upper = __shfl_sync(kAllLanes, static_cast<int>(rows.has_upper), p.row) != 0;
        if (!p.valid || !has_upper || upper.y + 1 != p.y || p.x < upper.first || p.x >= upper.end) return;
        const std::uint32_t above = p.index - view_.width;
        if (!is_free(above, step::kJumpDown)) return;
        if (p.x > p.first && p.x > upper.first && is_free(p.index - 1, step::kJumpRight) &&
            is_free(above - 1, step::kJumpRight) && is_free(above - 1, step::kJumpDown))
            return;
        join(upper_before + (p.x - upper.first), p.k);
    }
    // Of a lane's row with the last one that has pixels: around corners, or across a gap.
    __device__ void join_rows(const LaneRows& rows) {
        const PixelRun upper = rows.upper, lower = rows.run;
        if (upper.y + 1 == lower.y)
            step::each_diagonal(view_, upper, lower, [&](std::uint32_t i, std::uint32_t j) {
                join(rows.upper_before + (i - static_cast<std::uint32_t>(view_.index(upper.first, upper.y))),
                     rows.before + (j - static_cast<std::uint32_t>(view_.index(lower.first, lower.y))));
            });
        if (touch(upper, lower)) return;
        const step::Bridge bridge = step::bridge_between(upper, lower);
        if (!step::walk(view_, step::way_between_centres(bridge.upper_x, upper.y, bridge.lower_x, lower.y))
                 .found)
            join(rows.upper_before + (bridge.upper_x - upper.first),
                 rows.before + (bridge.lower_x - lower.first));
    }
    // Lets all lead to the first of their piece, and adds up areas there.
    __device__ void measure() {
        for (unsigned start = 0; start < count_; start += 32) {
            const unsigned k = start + lane_, first = k < count_ ? root(k) : 0;
            const unsigned all = __ballot_sync(kAllLanes, k < count_);
            if (k >= count_) continue;
            const unsigned same = __match_any_sync(all, first);
            if (lane_ == __ffs(static_cast<int>(same)) - 1) atomicAdd(&areas_[first], __popc(same));
            parents_[k] = first;
        }
    }
    __device__ void choose() {
        unsigned area = 0, pixel = 0;
        for (unsigned k = lane_; k < count_; k += 32) {
            const unsigned own = areas_[k];
            if (own > area) area = own, pixel = k;
        }
        area_ = __reduce_max_sync(kAllLanes, area);
        largest_ = __reduce_min_sync(kAllLanes, area == area_ ? pixel : ~0u);
    }

    step::PixelView view_;
    TriangleWarp& pixels_;
    unsigned count_, lane_;
    unsigned *parents_, *areas_;
    unsigned largest_ = 0, area_ = 0;
};

}  // namespace hexrelief::cuda
