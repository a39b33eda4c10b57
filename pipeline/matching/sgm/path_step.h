// One step of a path of semi-global matching (Hirschmueller 2008, eq. 13), its penalties, and the matching
// cost of two pixels: census and truncated colour difference.
#pragma once

#include <cstdint>

#include "pipeline/base/host_device.h"
#include "pipeline/matching/common/halves_step.h"

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

// The costs of paths are stored increased by p1, so that none is below p1 and no difference of them is below
// 0. A word holds those of one disparity or of two (see halves_step.h).
template <typename Word>
struct SmallStep {
    Word p1, minus_p1;  // minus_p1: 2^16 - p1
};
template <typename Word>
HEXRELIEF_HD SmallStep<Word> small_step(int p1) {
    return {in_halves<Word>(static_cast<std::uint32_t>(p1)),
            in_halves<Word>(0x10000u - static_cast<std::uint32_t>(p1))};
}
// The cost of the disparities beside the range: no path comes from there.
inline constexpr std::uint16_t kNoPath = 0xffff;

// The terms that all disparities of a pixel share: p1; the cost after a large step, less p1; and the number
// that is added to the cheapest path. least: of all costs at the previous pixel. p2: the penalty of a large
// step to this pixel.
template <typename Word>
struct PathSteps {
    SmallStep<Word> small_step;
    Word large_step, added;
};
template <typename Word>
HEXRELIEF_HD PathSteps<Word> path_steps(Word least, const SmallStep<Word>& small_step, Word p2) {
    return {small_step, static_cast<Word>(least + p2 - small_step.p1),
            static_cast<Word>(2 * small_step.p1 - least)};
}
// Returns the cost of a path that ends here at one disparity: min(before, lower + p1, upper + p1, least + p2)
// - least + cost. All path costs are increased by p1. before: the path's cost at the previous pixel at this
// disparity; lower and upper: at the neighbouring disparities. The result is at most cost + p2 + p1.
template <typename Word>
HEXRELIEF_HD Word path_cost(Word before, Word lower, Word upper, const PathSteps<Word>& steps, Word cost) {
    const Word stay =
        least_of_difference(before, steps.small_step.p1, steps.small_step.minus_p1, steps.large_step);
    return static_cast<Word>(least_of(lower, upper, stay) + steps.added + cost);
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

// The census transform of a 9x7 window (Zabih & Woodfill 1994): for each pixel except the centre a bit that
// says whether it is darker than the centre. Only the number of different bits counts, so each backend may
// order the bits as it likes.
inline constexpr int kCensusRadiusX = 4, kCensusRadiusY = 3, kCensusBits = 62;
inline constexpr int kCensusWeight = 3;
inline constexpr std::uint8_t kColorCut = 40;  // a channel's difference counts up to this

template <typename Word>
HEXRELIEF_HD Word cut_difference(Word difference) {
    return least_of(difference, in_halves<Word>(kColorCut));
}

// Returns the cost of one pixel of the right picture, 0..206, or of two in the halves of a word. hamming:
// 0..62; differences: the sum over three channels, or the one of a grey pair, each truncated.
template <typename Word>
HEXRELIEF_HD Word matching_cost(Word hamming, Word differences, int channels) {
    const auto colors = static_cast<Word>(differences >> (channels == 3 ? 3 : 1));
    return static_cast<Word>(kCensusWeight * hamming + (colors & in_halves<Word>(0xff)));
}

}  // namespace hexrelief::step
