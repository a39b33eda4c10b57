// How a warp looks at rims: as step::PixelLook, all lanes together. Every member function is called by all
// lanes with the same arguments and returns the same to all.
#pragma once

#include <cstdint>

#include "mesher/steps/crossings.h"

namespace hexrelief::cuda {

inline constexpr unsigned kWholeWarp = 0xffffffffu;

struct WarpLook {
    step::PixelView pixels;
    unsigned lane;

    // A lane a step.
    __device__ step::Crossing walk(const Vec2f& a, const Vec2f& b) const {
        const step::Way way = step::way_between(a.x, a.y, b.x, b.y);
        step::Crossing crossing{false, {0, 0, 0}};
        for (int first = 1; first <= way.steps && !crossing.found; first += 32) {
            const int k = first + static_cast<int>(lane);
            step::Crack met{0, 0, 0};
            const bool meets =
                k <= way.steps && step::steps_over(pixels, step::pixel_after(pixels, way, k - 1),
                                                   step::pixel_after(pixels, way, k), met);
            const unsigned meeting = __ballot_sync(kWholeWarp, meets);
            if (!meeting) continue;
            crossing = {true, from_lane(met, __ffs(meeting) - 1)};
        }
        return crossing;
    }
    // A lane a pixel of the window; the sums are taken in the order of one thread.
    __device__ step::RimPoint rim_point(const step::Crack& c) const {
        constexpr int kSide = 2 * step::kRimReach_px + 1;
        static_assert(kSide * kSide <= 32);
        const step::RimCrack own = step::rim_crack(pixels, c);
        const int row = static_cast<int>(lane) / kSide, u = c.x - step::kRimReach_px + lane % kSide,
                  v = c.y - step::kRimReach_px + row;
        const bool inside = row < kSide && u >= 0 && v >= 0 && u < pixels.width && v < pixels.height;
        const int flags = inside ? pixels.flags[pixels.index(u, v)] : 0;
        step::RimSums right, down;
        if (flags & step::kJumpRight) right = step::rim_term(pixels, own, u, v, 0);
        if (flags & step::kJumpDown) down = step::rim_term(pixels, own, u, v, 1);
        step::RimSums sums;
        unsigned adding = __ballot_sync(kWholeWarp, right.weight > 0 || down.weight > 0);
        for (; adding; adding &= adding - 1) {
            const int from = __ffs(adding) - 1;
            const auto get = [&](float value) { return __shfl_sync(kWholeWarp, value, from); };
            sums.add({get(right.weight), get(right.x), get(right.y), get(right.nx), 0.0f});
            sums.add({get(down.weight), get(down.x), get(down.y), 0.0f, get(down.ny)});
        }
        return step::rim_point_of(own, sums);
    }
    __device__ step::Crack nearest_crack(const Vec2f& p, float reach_px) const {
        const step::PixelWindow w = step::window_around(pixels, p, reach_px);
        const int columns = w.x1 - w.x0 + 1, count = columns * (w.y1 - w.y0 + 1);
        // distances above, places in the order of one thread below
        const auto key = [](float distance2, unsigned place) {
            return static_cast<unsigned long long>(__float_as_uint(distance2)) << 32 | place;
        };
        const unsigned long long none = key(reach_px * reach_px, 0);
        unsigned long long best = none;
        for (int i = static_cast<int>(lane); i < count; i += 32) {
            const int x = w.x0 + i % columns, y = w.y0 + i / columns;
            const int flags = pixels.flags[pixels.index(x, y)];
            if (flags & step::kJumpRight)
                best = min(best, key(step::distance2_to(pixels, {x, y, 0}, p), 2 * i + 1));
            if (flags & step::kJumpDown)
                best = min(best, key(step::distance2_to(pixels, {x, y, 1}, p), 2 * i + 2));
        }
        for (int by = 16; by > 0; by /= 2) best = min(best, __shfl_xor_sync(kWholeWarp, best, by));
        if (best == none) return {-1, -1, 0};
        const int place = static_cast<int>(best & 0xffffffffu) - 1, i = place / 2;
        return {w.x0 + i % columns, w.y0 + i / columns, place & 1};
    }

  private:
    __device__ static step::Crack from_lane(const step::Crack& c, int from) {
        return {__shfl_sync(kWholeWarp, c.x, from), __shfl_sync(kWholeWarp, c.y, from),
                __shfl_sync(kWholeWarp, c.down, from)};
    }
};

// Items that a warp is to look at together: a lane finds out which, visit(i) is called by all lanes. Those
// that follow each other go to different warps, for they are dear in the same places. needed(i) is called by
// all lanes, i >= count included.
template <typename Crew, typename Needed, typename Visit>
__device__ void each_needed(const Crew& crew, unsigned count, const Needed& needed, const Visit& visit) {
    const unsigned warps = crew.threads() / 32, warp = crew.thread() / 32;
    for (unsigned first = warp; first < count; first += 32 * warps) {
        const unsigned i = first + crew.lane() * warps;
        for (unsigned waiting = __ballot_sync(kWholeWarp, needed(i)); waiting; waiting &= waiting - 1) {
            const unsigned from = __ffs(waiting) - 1;
            visit(first + from * warps, from);
        }
    }
}

}  // namespace hexrelief::cuda
