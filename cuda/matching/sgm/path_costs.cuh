// The costs of a path at one pixel, in the registers of some lanes of a warp.
#pragma once

#include "cuda/matching/sgm/volume.h"

namespace hexrelief::cuda {

// The words of the steps hold two neighbouring disparities.
using PairStep = step::SmallStep<std::uint32_t>;
inline constexpr auto kNoPaths = step::in_halves<std::uint32_t>(step::kNoPath);

template <int kRun>
using LaneCosts = std::uint32_t[kPart<kRun> / 2];  // matching costs, a byte each
template <int kRun>
using LanePairs = std::uint32_t[kPart<kRun>];

__device__ inline int lane_of_group() {
    return static_cast<int>(threadIdx.x) % kGroup;
}

// Does the same as __byte_perm for a selector that is not constant but below 0x8888; __byte_perm would
// mask it each time.
__device__ inline std::uint32_t permuted(std::uint32_t a, std::uint32_t b, unsigned selector) {
    std::uint32_t result;
    asm("prmt.b32 %0, %1, %2, %3;" : "=r"(result) : "r"(a), "r"(b), "r"(selector));
    return result;
}

// Index of the first part of each run of a window that may move.
__device__ inline int far_part(PathPixel pixel) {
    return far_run(pixel) / step::kRunAlignment;
}
__device__ inline int near_part(PathPixel pixel) {
    return near_run(pixel) / step::kRunAlignment;
}

// Finds the pair of two parts when a window moves: parts are as long as the steps of runs.
static_assert(kPart<matching::kShortRun> == step::kRunAlignment);
struct PairSource {
    int far_lane, near_lane;  // lanes that hold the part for the lower half and the part for the upper half
    unsigned bytes;           // selector of the bytes of their pairs
    std::uint32_t none;       // halves that neither run had before

    // window: the preceding one; far, near: the parts.
    __device__ PairSource(PathPixel window, int far, int near) {
        bool far_upper, near_upper, far_none, near_none;
        find(window, far, far_lane, far_upper, far_none);
        find(window, near, near_lane, near_upper, near_none);
        bytes = (far_upper ? 0x32u : 0x10u) | (near_upper ? 0x7600u : 0x5400u);
        none = (far_none ? 0xffffu : 0u) | (near_none ? 0xffff0000u : 0u);
    }
    __device__ std::uint32_t take(std::uint32_t pair) const {
        const std::uint32_t lower = __shfl_sync(~0u, pair, far_lane, kGroup),
                            upper = __shfl_sync(~0u, pair, near_lane, kGroup);
        return permuted(lower, upper, bytes) | none;
    }

  private:
    __device__ static void find(PathPixel window, int part, int& lane, bool& upper, bool& none) {
        const int in_far = part - far_part(window), in_near = part - near_part(window);
        upper = in_far < 0 || in_far >= kGroup;
        lane = upper ? in_near : in_far;
        none = upper && (in_near < 0 || in_near >= kGroup);
    }
};

// The costs of a path. All are larger by p1 (see path_step.h) until sums are made of them. All
// lanes of a warp call each function together.
template <int kRun>
struct PathCosts {
    static constexpr bool kMoves = kRun == matching::kShortRun;  // windows of the whole range do not move
    static constexpr int kPairs = kPart<kRun>;
    LanePairs<kRun> pairs;
    std::uint32_t least;  // least cost, in both halves
    PathPixel window;     // without the penalty
    // Selectors for the pair of the preceding lane beside this one's first pair, and of the next lane
    // beside the last pair.
    unsigned below, above;

    // Begins a path, which has cost nothing so far, in any window. p1: in both halves.
    __device__ void begin(std::uint32_t p1) {
#pragma unroll
        for (int k = 0; k < kPairs; ++k) pairs[k] = p1;
        least = p1;
    }
    // Continues from values that `pairs` had at a pixel with this window.
    __device__ void load(const LanePairs<kRun>& values, PathPixel at) {
#pragma unroll
        for (int k = 0; k < kPairs; ++k) pairs[k] = values[k];
        find_least();
        move_to(at);
    }
    __device__ void move_to(PathPixel next) {
        const bool joined = near_run(next) == far_run(next) + kRun;
        const int lane = lane_of_group();
        window = next;
        // the far run of the last lane continues in the near run of the first lane
        below = lane > 0 ? 0x3210u : joined ? 0x1044u : 0x4444u;
        above = lane < kGroup - 1 ? 0x3210u : joined ? 0x4432u : 0x4444u;
    }

    // Advances to the next pixel, which has these matching costs. small_step: of all paths. may_move: a
    // constant, true if the pixel's window may differ.
    __device__ void advance(const LaneCosts<kRun>& costs, const PairStep& small_step, PathPixel next,
                            bool may_move) {
        const Beside beside =
            kMoves && may_move && __any_sync(~0u, moves_to(next)) ? move(next) : from_lanes_beside();
        advance(costs, small_step, next, beside);
    }
    // Advances two paths, whose instructions need not wait for each other.
    __device__ static void advance_both(PathCosts& a, const LaneCosts<kRun>& a_costs, PathPixel a_next,
                                        PathCosts& b, const LaneCosts<kRun>& b_costs, PathPixel b_next,
                                        const PairStep& small_step, bool may_move) {
        Beside beside_a, beside_b;
        if (kMoves && may_move && __any_sync(~0u, a.moves_to(a_next) || b.moves_to(b_next))) {
            beside_a = a.move(a_next);
            beside_b = b.move(b_next);
        } else {
            beside_a = a.from_lanes_beside();
            beside_b = b.from_lanes_beside();
        }
        a.advance(a_costs, small_step, a_next, beside_a);
        b.advance(b_costs, small_step, b_next, beside_b);
    }

  private:
    // The pairs beside the lane's own.
    struct Beside {
        std::uint32_t lower, upper;
    };
    __device__ bool moves_to(PathPixel next) const {
        return (next ^ window) > kPenalty;
    }
    // Keeps the pairs that are in both windows.
    __device__ Beside move(PathPixel next) {
        const int far = far_part(next) + lane_of_group(), near = near_part(next) + lane_of_group();
        const Beside beside{PairSource(window, far - 1, near - 1).take(pairs[kPairs - 1]),
                            PairSource(window, far + 1, near + 1).take(pairs[0])};
        const PairSource own(window, far, near);
#pragma unroll
        for (int k = 0; k < kPairs; ++k) pairs[k] = own.take(pairs[k]);
        move_to(next);
        return beside;
    }
    __device__ Beside from_lanes_beside() const {
        return {permuted(from_lane_at(-1, pairs[kPairs - 1]), kNoPaths, below),
                permuted(from_lane_at(1, pairs[0]), kNoPaths, above)};
    }
    __device__ void advance(const LaneCosts<kRun>& costs, const PairStep& small_step, PathPixel next,
                            const Beside& beside) {
        const auto steps =
            step::path_steps(least, small_step, step::in_halves<std::uint32_t>(next & kPenalty));
        std::uint32_t lower = beside.lower;
#pragma unroll
        for (int k = 0; k < kPairs; ++k) {
            const std::uint32_t before = pairs[k], upper = k + 1 < kPairs ? pairs[k + 1] : beside.upper;
            const std::uint32_t two = __byte_perm(costs[k / 2], 0, k % 2 ? 0x4342 : 0x4140);
            pairs[k] = step::path_cost(before, lower, upper, steps, two);
            lower = before;
        }
        find_least();
    }
    __device__ static std::uint32_t from_lane_at(int offset, std::uint32_t pair) {
        return __shfl_sync(~0u, pair, (lane_of_group() + offset) & (kGroup - 1), kGroup);
    }
    __device__ void find_least() {
        static_assert(kPairs == 4 || kPairs == 8);
        least = step::least_of(pairs[0], pairs[1], pairs[2]);
        if constexpr (kPairs == 4) {
            least = step::least_of(least, pairs[3]);
        } else {
            const std::uint32_t others = step::least_of(pairs[3], pairs[4], pairs[5]);
            least = step::least_of(step::least_of(pairs[6], pairs[7], least), others);
        }
        least = step::least_of(least, __byte_perm(least, 0, 0x1032));
#pragma unroll
        for (int step = kGroup / 2; step > 0; step /= 2)
            least = step::least_of(least, __shfl_xor_sync(~0u, least, step, kGroup));
    }
};

// Reads a lane's pairs from a pixel's sums, or from costs stored in the same layout; see DeviceVolume.
template <int kPairs>
__device__ void load_pairs(const std::uint16_t* pixel, std::uint32_t (&pairs)[kPairs]) {
    const uint4* const from = reinterpret_cast<const uint4*>(pixel) + lane_of_group();
#pragma unroll
    for (int k = 0; k < kPairs; k += 4) {
        const uint4 value = from[k / 4 * kGroup];
        pairs[k] = value.x;
        pairs[k + 1] = value.y;
        pairs[k + 2] = value.z;
        pairs[k + 3] = value.w;
    }
}
// Writes a lane's pairs in this layout.
template <int kPairs>
__device__ void store_pairs(const std::uint32_t (&pairs)[kPairs], std::uint16_t* pixel) {
    uint4* const to = reinterpret_cast<uint4*>(pixel) + lane_of_group();
#pragma unroll
    for (int k = 0; k < kPairs; k += 4)  // one access; the compiler makes four of an assignment
        __stcg(to + k / 4 * kGroup, make_uint4(pairs[k], pairs[k + 1], pairs[k + 2], pairs[k + 3]));
}

}  // namespace hexrelief::cuda
