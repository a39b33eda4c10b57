// The costs of a path at one pixel, in the registers of some lanes of a warp.
#pragma once

#include "cuda/matching/sgm/volume.h"
#include "pipeline/matching/sgm/path_step.h"

namespace hexrelief::cuda {

// Of disparities outside of a window: more than any path costs, as pairs.
inline constexpr std::uint32_t kNoPaths = 0xffffffffu;

using LaneCosts = std::uint32_t[kLaneEntries / 4];  // matching costs, a byte each
using LanePairs = std::uint32_t[kLanePairs];

__device__ inline int lane_of_group() {
    return static_cast<int>(threadIdx.x) % kGroup;
}

// A SearchWindow as it lies in memory, far_run in the lower half: taken apart only where it is used, so that
// nothing waits for it where it is read.
using PackedWindow = std::uint32_t;
__device__ inline PackedWindow packed(const SearchWindow& window) {
    return static_cast<std::uint32_t>(window.near_run) << 16 | static_cast<std::uint32_t>(window.far_run);
}

// The disparities that a lane has of a window, in units of kLaneEntries, and which lane has some of these.
__device__ inline int part_of_lane(PackedWindow window, int lane) {
    const unsigned first = lane < kRunLanes ? window & 0xffffu : window >> 16;
    return static_cast<int>(first / kLaneEntries) + lane % kRunLanes;
}
__device__ inline int lane_of_part(PackedWindow window, int part) {
    const unsigned in_far = static_cast<unsigned>(part) - (window & 0xffffu) / kLaneEntries,
                   in_near = static_cast<unsigned>(part) - (window >> 16) / kLaneEntries;
    if (in_far < kRunLanes) return static_cast<int>(in_far);
    return in_near < kRunLanes ? kRunLanes + static_cast<int>(in_near) : -1;
}

// All are p1 larger (see step::path_costs_of_pair), until sums are made of them. All lanes of a warp call
// each member together.
struct PathCosts {
    LanePairs pairs;
    std::uint32_t least;  // as a pair
    PackedWindow window;
    int lower_lane, upper_lane;  // that have the parts beside the lane's own, or -1

    // A path that begins costs nothing before. p1: as a pair.
    __device__ void begin(PackedWindow first, std::uint32_t p1) {
#pragma unroll
        for (int k = 0; k < kLanePairs; ++k) pairs[k] = p1;
        least = p1;
        move_to(first);
    }
    // values: as they were in `pairs`, at a pixel with this window.
    __device__ void load(const LanePairs& values, PackedWindow at) {
#pragma unroll
        for (int k = 0; k < kLanePairs; ++k) pairs[k] = values[k];
        find_least();
        move_to(at);
    }

    // To the next pixel, which has these matching costs and this window. p1: as a pair; p2: of a large step
    // there.
    __device__ void advance(const LaneCosts& costs, std::uint32_t p1, std::uint32_t p2, PackedWindow next) {
        std::uint32_t below, above;
        if (__any_sync(~0u, next != window)) {
            const int part = part_of_lane(next, lane_of_group()), lane = lane_of_part(window, part);
            below = from_lane(pairs[kLanePairs - 1], lane_of_part(window, part - 1));
            above = from_lane(pairs[0], lane_of_part(window, part + 1));
#pragma unroll
            for (int k = 0; k < kLanePairs; ++k) pairs[k] = from_lane(pairs[k], lane);
            move_to(next);
        } else {
            below = from_lane(pairs[kLanePairs - 1], lower_lane);
            above = from_lane(pairs[0], upper_lane);
        }
        const step::PairSteps steps = step::pair_steps(least, p1, step::pair_of(p2));
        std::uint32_t lower = __byte_perm(below, pairs[kLanePairs - 1], 0x5432);
        const std::uint32_t uppermost = __byte_perm(pairs[0], above, 0x5432);
#pragma unroll
        for (int k = 0; k < kLanePairs; ++k) {
            const std::uint32_t before = pairs[k], upper = k + 1 < kLanePairs ? pairs[k + 1] : uppermost;
            const std::uint32_t two = __byte_perm(costs[k / 2], 0, k % 2 ? 0x4342 : 0x4140);
            pairs[k] = step::path_costs_of_pair(before, lower, upper, steps, two);
            lower = before;
        }
        find_least();
    }

  private:
    __device__ static std::uint32_t from_lane(std::uint32_t pair, int lane) {
        const std::uint32_t there = __shfl_sync(~0u, pair, lane, kGroup);
        return lane < 0 ? kNoPaths : there;
    }
    __device__ void move_to(PackedWindow next) {
        window = next;
        const int part = part_of_lane(next, lane_of_group());
        lower_lane = lane_of_part(next, part - 1);
        upper_lane = lane_of_part(next, part + 1);
    }
    __device__ void find_least() {
        least = step::min_of_pairs(step::min_of_pairs(pairs[0], pairs[1]), pairs[2], pairs[3]);
        least = step::min_of_pairs(least, __byte_perm(least, 0, 0x1032));
#pragma unroll
        for (int step = kGroup / 2; step > 0; step /= 2)
            least = step::min_of_pairs(least, __shfl_xor_sync(~0u, least, step, kGroup));
    }
};

}  // namespace hexrelief::cuda
