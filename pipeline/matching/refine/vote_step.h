// Votes of a window's pixels on the disparity of the pixel in its middle. Each pixel votes for the disparity
// of its plane there; its weight grows with the similarity of its colour.
#pragma once

#include <cstddef>
#include <cstdint>

#include "pipeline/base/host_device.h"
#include "pipeline/matching/refine/consistency_step.h"
#include "pipeline/matching/refine/slope_step.h"

namespace hexrelief::step {

// A window of votes: its radius in strides, the stride in px, and whether only dark pixels
// vote, as near discontinuities.
struct VoteReach {
    int radius, stride;
    bool dark_only;

    HEXRELIEF_HD constexpr int side() const { return 2 * radius + 1; }
    HEXRELIEF_HD constexpr int votes() const {
        return dark_only ? (side() * side() + 1) / 2 : side() * side();
    }
};
inline constexpr VoteReach kNearVotes{6, 1, true}, kHoleVotes{4, 7, false};
inline constexpr int kMostVotes = 85;
static_assert(kNearVotes.votes() <= kMostVotes && kHoleVotes.votes() <= kMostVotes);
// Voters from this colour step on (largest difference of a channel) have no weight.
inline constexpr int kOtherColor = 32;

// The largest weight of a voter: of a matched pixel whose side is certain.
inline constexpr std::uint8_t kMatchedWeight = 6;

// A larger step between neighbours is a discontinuity. Votes are taken up to kNear_px away from
// it along both axes, in rounds: each moves it a little.
inline constexpr int kDiscontinuity = 24;  // 1/16 px
inline constexpr int kNear_px = 1;
inline constexpr int kVoteRounds = 3;
HEXRELIEF_HD bool discontinuous(int own, int other) {
    const int difference = other - own;
    return (own >= 0) & (other >= 0) & ((difference > kDiscontinuity) | (difference < -kDiscontinuity));
}

// True if a pixel has a discontinuity to its left or right, above or below.
HEXRELIEF_HD bool beside_discontinuity(const std::int16_t* at, std::ptrdiff_t stride) {
    const int own = *at;
    return discontinuous(own, at[-1]) | discontinuous(own, at[1]) | discontinuous(own, at[-stride]) |
           discontinuous(own, at[stride]);
}

// Returns a voter's weight by its distance `ring`, in strides along the farther axis: 16 exp(-(r/7)^2),
// in holes 16 exp(-(r/4)^2).
HEXRELIEF_HD std::uint16_t distance_weight(bool hole, int ring) {
    constexpr std::uint8_t kNear[kNearVotes.radius + 1] = {16, 16, 15, 13, 12, 10, 8};
    constexpr std::uint8_t kHole[kHoleVotes.radius + 1] = {16, 15, 12, 9, 6};
    return hole ? kHole[ring] : kNear[ring];
}

// Returns the similarity of two colours, 0..64. hole_likeness() falls faster, because voters in
// holes are far away.
template <typename Weight, typename Step>
HEXRELIEF_HD Weight near_likeness(Step color_step) {
    const auto below = static_cast<Step>(kOtherColor - (color_step > kOtherColor ? kOtherColor : color_step));
    return static_cast<Weight>((below * below) >> 4);
}
template <typename Weight, typename Step>
HEXRELIEF_HD Weight hole_likeness(Step color_step) {
    const auto likeness = near_likeness<Weight>(color_step);
    return static_cast<Weight>(static_cast<Weight>(likeness * likeness) >> 6);
}

// Returns a vote's weight, at most 64 * 16 * 6 / 32, so that the sum of all votes fits into 16 bits; 0 if the
// voter is not known. own: the voter's own weight, at most kMatchedWeight. Weight: std::uint16_t or unsigned.
template <typename Weight>
HEXRELIEF_HD Weight vote_weight(Weight likeness, Weight at_distance, Weight own, bool known) {
    const auto weight = static_cast<Weight>(static_cast<Weight>(likeness * at_distance) * own);
    return known ? static_cast<Weight>(weight >> 5) : Weight{0};
}

// Returns the disparity that a voter votes for. change: plane_change() from the pixel in the
// middle to the voter.
template <typename Int>
HEXRELIEF_HD Int vote(Int voter, Int change) {
    const auto disparity = static_cast<Int>(voter - static_cast<Int>(change >> 4));
    return disparity > 0 ? disparity : Int{0};
}

// The search for the weighted median, the least disparity up to which votes have half the weight:
// it lies in lo..hi.
// Returns the middle of lo..hi.
template <typename Int>
HEXRELIEF_HD Int middle(Int lo, Int hi) {
    return static_cast<Int>(lo + ((hi - lo) >> 1));
}
// Halves lo..hi. up_to_middle is the weight of the votes up to middle(lo, hi).
template <typename Weight, typename Int>
HEXRELIEF_HD void narrow(Weight up_to_middle, Weight total, Int& lo, Int& hi) {
    const Int mid = middle(lo, hi);
    const auto above = static_cast<Int>(mid + 1 < hi ? mid + 1 : hi);
    const bool reached = up_to_middle >= static_cast<Weight>(total - up_to_middle);
    lo = reached ? lo : above;
    hi = reached ? mid : hi;
}

// Returns the same median bit by bit: the largest disparity that more than half of the weight reaches.
// weight_from(disparity) returns the weight of the votes that are at least `disparity`. least: the least vote
// that has a weight; highest_bit: of the largest vote's difference from it, 0 if they are equal.
template <typename WeightFrom>
HEXRELIEF_HD unsigned median_by_bits(unsigned least, unsigned highest_bit, unsigned total,
                                     const WeightFrom& weight_from) {
    unsigned median = least;
    for (unsigned bit = highest_bit; bit > 0; bit /= 2)
        if (weight_from(median + bit) > total / 2) median += bit;
    return median;
}
// Returns 1 in each half whose vote is at least as large as a disparity. more_by_two: the votes plus 2;
// complement: the bitwise complement of the disparity.
template <typename Word>
HEXRELIEF_HD Word reaching(Word more_by_two, Word complement) {
    return least_of_sum_or_0(more_by_two, complement, in_halves<Word>(1));
}

}  // namespace hexrelief::step
