// The pieces of a triangle by a warp, as TrianglePieces finds them: pixels that hang together.
#pragma once

#include <cstdint>

#include "cuda/triangle_warp.cuh"
#include "mesher/steps/triangle_sides.h"

namespace hexrelief::cuda {

// Where pixels lead to lower ones of their pieces, the lowest of each to itself, with the pieces' areas: in
// shared memory, in one word; each warp has a part of its own, and one for larger triangles is taken for a
// time.
struct SharedPieces {
    static constexpr unsigned kOwn = 4096, kLarge = 2048;
    unsigned first;

    __device__ static unsigned* all() {
        __shared__ unsigned words[kOwn + kLarge];
        return words;
    }
    __device__ void set(unsigned i, unsigned parent) const { all()[first + i] = parent; }
    __device__ unsigned parent(unsigned i) const {
        return static_cast<const volatile unsigned*>(all())[first + i] & 0xffff;
    }
    __device__ bool hang(unsigned root, unsigned parent) const {
        return atomicCAS(all() + first + root, root, parent) == root;
    }
    __device__ void add(unsigned root, unsigned area) const { atomicAdd(all() + first + root, area << 16); }
    __device__ unsigned area(unsigned i) const { return all()[first + i] >> 16; }
};
// The same for any number of pixels.
struct PooledPieces {
    unsigned *parents, *areas;

    __device__ void set(unsigned i, unsigned parent) const {
        static_cast<volatile unsigned*>(parents)[i] = parent;
        areas[i] = 0;
    }
    __device__ unsigned parent(unsigned i) const { return static_cast<const volatile unsigned*>(parents)[i]; }
    __device__ bool hang(unsigned root, unsigned parent) const {
        return atomicCAS(&parents[root], root, parent) == root;
    }
    __device__ void add(unsigned root, unsigned area) const { atomicAdd(&areas[root], area); }
    __device__ unsigned area(unsigned i) const { return static_cast<const volatile unsigned*>(areas)[i]; }
};

template <typename Room>
class WarpPieces {
  public:
    __device__ WarpPieces(const step::PixelView& view, TriangleWarp& pixels, unsigned count, const Room& room)
        : view_(view), pixels_(pixels), room_(room), count_(count), lane_(threadIdx.x % 32) {}

    // Finds them and the largest, the first of equal ones.
    __device__ void find() {
        begin();
        __syncwarp();
        pixels_.each_rows([&](const LaneRows& rows) {
            pixels_.each_pixel(rows, [&](const LanePixel& p) { join_upper(rows, p); });
        });
        __syncwarp();
        flatten();
        pixels_.each_rows([&](const LaneRows& rows) {
            if (rows.own && rows.has_upper) join_rows(rows);
            __syncwarp();
        });
        flatten();
        measure();
        __syncwarp();
        choose();
    }
    __device__ bool is_largest(unsigned pixel) const { return room_.parent(pixel) == largest_; }
    __device__ unsigned largest() const { return largest_; }  // its first pixel
    __device__ unsigned area() const { return area_; }        // of the largest

  private:
    __device__ bool is_free(std::uint32_t index, std::uint8_t jump) const {
        return !(view_.flags[index] & jump);
    }
    // Into the cache, for later.
    __device__ static void fetch(const void* place) { asm volatile("prefetch.global.L1 [%0];" ::"l"(place)); }
    // Pixels of a row without a jump between them lead to the first of them.
    __device__ void begin() {
        unsigned last = 0;
        pixels_.each_pixel([&](const LanePixel& p) {
            const bool begins = p.valid && (p.x == p.first || !is_free(p.index - 1, step::kJumpRight));
            const unsigned begin = __ballot_sync(kAllLanes, begins) & ((2u << lane_) - 1);
            const unsigned start = begin ? p.k - lane_ + 31 - __clz(begin) : last;
            if (p.valid) room_.set(p.k, start);
            if (p.valid) fetch(view_.disparity + p.index);
            last = __shfl_sync(kAllLanes, start, 31);
        });
    }
    __device__ unsigned root(unsigned i) const {
        for (unsigned parent = room_.parent(i); parent != i; parent = room_.parent(i)) i = parent;
        return i;
    }
    __device__ void join(unsigned i, unsigned j) {
        for (;;) {
            i = root(i);
            j = root(j);
            if (i == j || room_.hang(max(i, j), min(i, j))) return;
        }
    }
    // With the pixel above, unless those to the left of both have told already.
    __device__ void join_upper(const LaneRows& rows, const LanePixel& p) {
        const int upper_y = __shfl_sync(kAllLanes, rows.upper.y, p.row),
                  upper_first = __shfl_sync(kAllLanes, rows.upper.first, p.row),
                  upper_end = __shfl_sync(kAllLanes, rows.upper.end, p.row);
        const unsigned upper_before = __shfl_sync(kAllLanes, rows.upper_before, p.row);
        const bool has_upper = __shfl_sync(kAllLanes, static_cast<int>(rows.has_upper), p.row) != 0;
        if (!p.valid || !has_upper || upper_y + 1 != p.y || p.x < upper_first || p.x >= upper_end) return;
        const std::uint32_t above = p.index - view_.width;
        const bool inner = p.x > p.first && p.x > upper_first;
        const std::uint8_t own = view_.flags[above], left = inner ? view_.flags[above - 1] : 0xff,
                           lower_left = inner ? view_.flags[p.index - 1] : 0xff;
        if (own & step::kJumpDown) return;
        if (!(left & (step::kJumpRight | step::kJumpDown)) && !(lower_left & step::kJumpRight)) return;
        join(upper_before + (p.x - upper_first), p.k);
    }
    // Of a lane's row with the last one that has pixels: around corners, or across a gap.
    __device__ void join_rows(const LaneRows& rows) {
        const PixelRun upper = rows.upper, lower = rows.run;
        const auto join_pixels = [&](std::uint32_t i, std::uint32_t j) {
            join(rows.upper_before + (i - static_cast<std::uint32_t>(view_.index(upper.first, upper.y))),
                 rows.before + (j - static_cast<std::uint32_t>(view_.index(lower.first, lower.y))));
        };
        std::uint32_t i = 0, j = 0;
        unsigned many = 0;
        if (upper.y + 1 == lower.y)
            step::each_diagonal(view_, upper, lower, [&](std::uint32_t a, std::uint32_t b) {
                if (many++) join_pixels(i, j);  // the last one below: mostly there is but one
                i = a;
                j = b;
            });
        if (!touch(upper, lower)) {
            const step::Bridge bridge = step::bridge_between(upper, lower);
            const step::Way way = step::way_between_centres(bridge.upper_x, upper.y, bridge.lower_x, lower.y);
            if (!step::walk(view_, way).found) {
                many = 1;  // nor do they meet at a corner
                i = static_cast<std::uint32_t>(view_.index(bridge.upper_x, upper.y));
                j = static_cast<std::uint32_t>(view_.index(bridge.lower_x, lower.y));
            }
        }
        if (many) join_pixels(i, j);
    }
    // Lets all lead to the first of their piece at once.
    __device__ void flatten() const {
        for (bool goes_on = true; goes_on;) {
            goes_on = false;
            for (unsigned k = lane_; k < count_; k += 32) {
                const unsigned parent = room_.parent(k), next = room_.parent(parent);
                if (next == parent) continue;
                room_.set(k, next);
                goes_on = true;
            }
            __syncwarp();
            goes_on = __any_sync(kAllLanes, goes_on);
        }
    }
    // Adds up the areas of pieces at the first of each.
    __device__ void measure() const {
        for (unsigned start = 0; start < count_; start += 32) {
            const unsigned k = start + lane_, first = k < count_ ? room_.parent(k) : ~0u;
            unsigned left = __ballot_sync(kAllLanes, k < count_);
            while (left) {  // mostly there are but two pieces
                const unsigned one = __shfl_sync(kAllLanes, first, __ffs(static_cast<int>(left)) - 1),
                               same = __ballot_sync(kAllLanes, first == one);
                if (lane_ == 0) room_.add(one, __popc(same));
                left &= ~same;
            }
        }
    }
    __device__ void choose() {
        unsigned area = 0, pixel = 0;
        for (unsigned k = lane_; k < count_; k += 32) {
            const unsigned own = room_.area(k);
            if (own > area) area = own, pixel = k;
        }
        area_ = most_of_lanes(area);
        largest_ = least_of_lanes(area == area_ ? pixel : ~0u);
    }

    step::PixelView view_;
    TriangleWarp& pixels_;
    Room room_;
    unsigned count_, lane_;
    unsigned largest_ = 0, area_ = 0;
};

}  // namespace hexrelief::cuda
