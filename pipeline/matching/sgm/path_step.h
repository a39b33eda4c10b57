// One step of a path of semi-global matching (Hirschmueller 2008, eq. 13), and its penalties.
#pragma once

#include <cstdint>

#include "mesher/common/host_device.h"

namespace hexrelief::step {

// Penalties of a disparity step along a path: of 1 px, and of more. 0 < p1 < p2.
struct PathPenalties {
    int p1 = 45;
    int p2 = 330;

    bool operator==(const PathPenalties&) const = default;
};
inline constexpr int kFullColorStep = 25;  // from this colour step on, a large step costs only p1 + 1

// Returns the penalty of a large step, which falls with the colour step there (the largest
// difference of a channel).
HEXRELIEF_HD std::uint16_t large_step_penalty(const PathPenalties& penalties, int color_step) {
    const int least = penalties.p1 + 1;
    const int falling = penalties.p2 - (penalties.p2 - least) * color_step / kFullColorStep;
    return static_cast<std::uint16_t>(falling > least ? falling : least);
}

// Returns the cost of a path that ends here at one disparity, at most cost + p2. before: the path's
// cost at the previous pixel at this disparity; lower and upper: at the disparities beside it; least:
// the least of all.
HEXRELIEF_HD std::uint16_t path_cost(std::uint16_t before, std::uint16_t lower, std::uint16_t upper,
                                     std::uint16_t least, std::uint16_t p1, std::uint16_t p2,
                                     std::uint8_t cost) {
    const auto small_step = static_cast<std::uint16_t>((lower < upper ? lower : upper) + p1);
    const auto large_step = static_cast<std::uint16_t>(least + p2);
    std::uint16_t best = before < large_step ? before : large_step;
    best = best < small_step ? best : small_step;
    return static_cast<std::uint16_t>(best - least + cost);
}
// The cost of the disparities beside the range: no path comes from there.
inline constexpr std::uint16_t kNoPath = 30000;

// The functions below compute two disparities at once, as 16-bit numbers side by side in a word. Their costs
// are stored increased by p1, so that none is below p1 and no sum or difference leaves its half of the word.
HEXRELIEF_HD std::uint32_t min_of_pairs(std::uint32_t a, std::uint32_t b) {
#ifdef __CUDA_ARCH__
    return __vminu2(a, b);
#else
    const std::uint32_t low_a = a & 0xffffu, low_b = b & 0xffffu;
    const std::uint32_t high_a = a & ~0xffffu, high_b = b & ~0xffffu;
    return (low_a < low_b ? low_a : low_b) | (high_a < high_b ? high_a : high_b);
#endif
}
HEXRELIEF_HD std::uint32_t min_of_pairs(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
#if defined(__CUDA_ARCH__) && __CUDA_ARCH__ >= 900
    return __vimin3_u16x2(a, b, c);
#else
    return min_of_pairs(min_of_pairs(a, b), c);
#endif
}
HEXRELIEF_HD std::uint32_t pair_of(std::uint32_t value) {
    return value | value << 16;
}
// A pair of p1, 0 < p1 < 2^16, and a pair of 2^16 - p1.
struct PairPenalty {
    std::uint32_t p1, minus_p1;
};
HEXRELIEF_HD PairPenalty pair_penalty(int p1) {
    return {pair_of(static_cast<std::uint32_t>(p1)), pair_of(0x10000u - static_cast<std::uint32_t>(p1))};
}
// The terms that all disparities of a pixel share, as pairs: p1; the cost after a large step, less p1; and
// the number that is added to the cheapest path. `least` is increased by p1 as well.
struct PairSteps {
    PairPenalty small_step;
    std::uint32_t large_step, added;
};
HEXRELIEF_HD PairSteps pair_steps(std::uint32_t least, const PairPenalty& small_step, std::uint32_t p2) {
    return {small_step, least + p2 - small_step.p1, 2 * small_step.p1 - least};
}
// As path_cost(), for two disparities at once.
HEXRELIEF_HD std::uint32_t path_costs_of_pair(std::uint32_t before, std::uint32_t lower, std::uint32_t upper,
                                              const PairSteps& steps, std::uint32_t costs) {
#if defined(__CUDA_ARCH__) && __CUDA_ARCH__ >= 900
    const std::uint32_t stay = __viaddmin_u16x2(before, steps.small_step.minus_p1, steps.large_step);
#else
    const std::uint32_t stay = min_of_pairs(before - steps.small_step.p1, steps.large_step);
#endif
    return min_of_pairs(lower, upper, stay) + steps.added + costs;
}

// Returns the vertex of the parabola through the costs at three neighbouring disparities, in 1/16 px
// from the middle one.
HEXRELIEF_HD int parabola_vertex(int lower, int middle, int upper) {
    const int curvature = lower + upper - 2 * middle, difference = lower - upper;
    if (curvature <= 0) return 0;
    const int half = curvature / 2;
    return (8 * difference + (difference > 0 ? half : -half)) / curvature;
}

// Returns a key that orders disparities by their sum of path costs; equal sums by the smaller
// disparity. disparity < 2^16.
HEXRELIEF_HD std::uint32_t winner_key(std::uint16_t sum, std::uint32_t disparity) {
    return static_cast<std::uint32_t>(sum) << 16 | disparity;
}
inline constexpr std::uint32_t kNoWinner = 0xffffffffu;
HEXRELIEF_HD int winner_disparity(std::uint32_t key) {
    return static_cast<int>(key & 0xffffu);
}
HEXRELIEF_HD int winner_sum(std::uint32_t key) {
    return static_cast<int>(key >> 16);
}

}  // namespace hexrelief::step
