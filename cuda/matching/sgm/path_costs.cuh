// The costs of a path at one pixel, in the registers of some lanes of a warp.
#pragma once

#include "cuda/common/warp_reduce.cuh"
#include "pipeline/matching/sgm/path_step.h"

namespace hexrelief::cuda {

inline constexpr std::uint32_t kNoPaths = step::kNoPath * 0x10001u;  // a pair

// Of all lanes of a group, each of which calls. Two equal halves.
template <int kGroup>
__device__ std::uint32_t least_pair_of_group(std::uint32_t pair) {
    pair = step::min_of_pairs(pair, __byte_perm(pair, 0, 0x1032));
    if constexpr (kGroup == 32) {
        return least_of_lanes(pair);
    } else {
#pragma unroll
        for (int step = kGroup / 2; step > 0; step /= 2)
            pair = step::min_of_pairs(pair, __shfl_xor_sync(~0u, pair, step, kGroup));
        return pair;
    }
}

// How a warp holds the disparities of a pixel: kGroup lanes have kPer each, which follow each other, the k-th
// of them beside the one that is kPer / 2 farther. kPartial: not all of the last lane's are searched.
template <int kGroupLanes, int kPerLane, bool kPartialLane>
struct PathShape {
    static constexpr int kGroup = kGroupLanes, kPer = kPerLane, kPairs = kPerLane / 2;
    static constexpr bool kPartial = kPartialLane;
    using Pairs = std::uint32_t[kPairs];
    using Costs = std::uint32_t[kPer / 4];
};

template <typename Shape>
struct LaneRange {
    int lane;
    bool any, last;  // has disparities that are searched; the last of them
    std::uint32_t inside[Shape::kPartial ? Shape::kPairs : 1];  // all bits of those that are searched

    __device__ explicit LaneRange(int count) : lane(static_cast<int>(threadIdx.x % Shape::kGroup)) {
        any = first() < count;
        last = any && first() + Shape::kPer >= count;
        if constexpr (Shape::kPartial)
#pragma unroll
            for (int k = 0; k < Shape::kPairs; ++k)
                inside[k] = (first() + k < count ? 0xffffu : 0) |
                            (first() + k + Shape::kPairs < count ? 0xffff0000u : 0);
    }
    __device__ int first() const {
        return lane * Shape::kPer;
    }
    // The pair, or what stands for those that are not searched.
    __device__ std::uint32_t or_none(std::uint32_t pair, int k, std::uint32_t none) const {
        if constexpr (Shape::kPartial) return (pair & inside[k]) | (none & ~inside[k]);
        return pair;
    }
};

// All are p1 larger (see step::path_costs_of_pair), until sums are made of them.
template <typename Shape>
struct PathCosts {
    typename Shape::Pairs pairs;
    std::uint32_t least;  // as a pair

    // A path that begins costs nothing before. p1: as a pair.
    __device__ void begin(const LaneRange<Shape>& range, std::uint32_t p1) {
#pragma unroll
        for (int k = 0; k < Shape::kPairs; ++k) pairs[k] = range.or_none(p1, k, kNoPaths);
        least = p1;
    }
    // values: as they were in `pairs`.
    __device__ void load(const typename Shape::Pairs& values, const LaneRange<Shape>& range) {
#pragma unroll
        for (int k = 0; k < Shape::kPairs; ++k) pairs[k] = values[k];
        find_least(range);
    }

    // To the next pixel, whose matching costs these are. p1: as a pair; p2: of a large step there.
    __device__ void advance(const typename Shape::Costs& costs, std::uint32_t p1, std::uint32_t p2,
                            const LaneRange<Shape>& range) {
        constexpr int kPairs = Shape::kPairs;
        const std::uint32_t lane_below = __shfl_up_sync(~0u, pairs[kPairs - 1], 1, Shape::kGroup);
        const std::uint32_t lane_above = __shfl_down_sync(~0u, pairs[0], 1, Shape::kGroup);
        const std::uint32_t below = range.lane == 0 ? kNoPaths : lane_below;
        const std::uint32_t above = range.last ? kNoPaths : lane_above;
        const step::PairSteps steps = step::pair_steps(least, p1, step::pair_of(p2));
        std::uint32_t lower = __byte_perm(below, pairs[kPairs - 1], 0x5432);
        const std::uint32_t uppermost = __byte_perm(pairs[0], above, 0x5432);
#pragma unroll
        for (int k = 0; k < kPairs; ++k) {
            const std::uint32_t before = pairs[k], upper = k + 1 < kPairs ? pairs[k + 1] : uppermost;
            const std::uint32_t two = __byte_perm(costs[k / 2], 0, k % 2 ? 0x4342 : 0x4140);
            pairs[k] = range.or_none(step::path_costs_of_pair(before, lower, upper, steps, two), k, kNoPaths);
            lower = before;
        }
        find_least(range);
    }

  private:
    __device__ void find_least(const LaneRange<Shape>& range) {
        std::uint32_t lowest = step::min_of_pairs(pairs[0], pairs[1]);
#pragma unroll
        for (int k = 2; k < Shape::kPairs; k += 2)
            lowest = step::min_of_pairs(lowest, pairs[k], pairs[k + 1]);
        least = least_pair_of_group<Shape::kGroup>(range.any ? lowest : 0xffffffffu);
    }
};

}  // namespace hexrelief::cuda
