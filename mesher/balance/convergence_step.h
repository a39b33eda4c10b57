// Balancing: derives from the sums of one iteration the target weight and the triangle threshold of the next,
// and decides whether the level is done.
#pragma once

#include <cstdint>

#include "mesher/balance/edge_integrals_step.h"

namespace hexrelief::step {

// fraction bits of weights as integers, whose sums do not depend on the order
inline constexpr int kWeightBits = 32;
inline constexpr int kCheckEvery = 4;  // iterations between two checks of the deviation
inline constexpr float kFar = 0.03f;   // relative deviation above which a level is far from balance
inline constexpr int kThinShare = 98, kThinOf = 10000;  // kThinShare / kThinOf of the triangles may be thin
// factor by which the threshold changes in an iteration, up or down
inline constexpr float kThresholdStep = 1.04f;

// Late iterations, those beyond the planned ones, have a steep penalty (ShapeLimits). They use a
// smaller factor, or 1 if the share of thin triangles is between kThinEnough and kThinShare; otherwise
// share and threshold would oscillate.
inline constexpr float kLateThresholdStep = 1.02f;
inline constexpr int kThinEnough = 50;
// The finest level ends if kLateCheckEvery late iterations lower the deviation by less than 3 %.
inline constexpr int kLateCheckEvery = 20;
inline constexpr float kLateStuck = 0.97f;

// Sums over all cells with six neighbours (weight, deviation) and over the triangles of all vertices (thin).
struct BalanceSums {
    std::int64_t weight, deviation, thin;
};

// Returns a weight as an integer. Weights are at most some thousands, so sums of millions of them
// fit into 64 bits.
HEXRELIEF_HD std::int64_t whole_weight(float weight) {
    return static_cast<std::int64_t>(weight * static_cast<float>(std::int64_t{1} << kWeightBits));
}

// Adds a cell whose weight should be `target`.
HEXRELIEF_HD void add_cell(float weight, float target, BalanceSums& sums) {
    const float missing = target - weight;
    sums.weight += whole_weight(weight);
    sums.deviation += whole_weight(missing < 0 ? -missing : missing);
}

// Returns the mean of `cells` weights from the sum of their integers.
HEXRELIEF_HD float mean_weight(std::int64_t sum, int cells) {
    return static_cast<float>(static_cast<double>(sum) /
                              (static_cast<double>(std::int64_t{1} << kWeightBits) * cells));
}

// True if more than share / kThinOf of all triangles are thin; `thin` counts each at its three vertices.
HEXRELIEF_HD bool has_thin(const BalanceView& v, std::int64_t thin, int share) {
    const std::int64_t triangles = std::int64_t{6} * (v.lattice.columns - 1) * (v.lattice.rows - 1);
    return thin * kThinOf > triangles * share;
}

// Returns the distortion E above which a triangle counts as too thin in the next iteration.
HEXRELIEF_HD float next_threshold(const BalanceView& v, std::int64_t thin, bool late, float threshold) {
    const float factor = late ? kLateThresholdStep : kThresholdStep;
    if (has_thin(v, thin, kThinShare)) return max_of(threshold * (1.0f / factor), v.least_threshold);
    if (late && has_thin(v, thin, kThinEnough)) return threshold;
    return min_of(threshold * factor, v.most_threshold);
}

// When a level ends. planned, most: its planned and largest number of iterations; near: relative deviation
// that is good enough; stuck: the level makes no progress if the deviation exceeds this share of the one at
// the preceding check, unless it is far from balance.
struct BalanceLimits {
    int planned, most;
    float near, stuck;
    bool finest;  // no level follows
};

// True if iteration t is beyond the planned ones.
HEXRELIEF_HD bool is_late(const BalanceLimits& limits, int t) {
    return t >= limits.planned;
}

// True if the level is done before iteration t > 0. mean_deviation: mean deviation of the weights from
// `target` in iteration t - 1; in_shape: true if at most kThinShare of its triangles were thin; before:
// relative deviation at the preceding check, which the caller keeps from call to call and sets to a
// large number at first.
HEXRELIEF_HD bool is_done(const BalanceLimits& limits, int t, float mean_deviation, float target,
                          bool in_shape, float& before) {
    const float deviation = target > 0 ? mean_deviation / target : 0.0f;
    const bool near = deviation < kFar;
    if (is_late(limits, t) && near && (in_shape || !limits.finest)) return true;
    const bool late_check = limits.finest && t > limits.planned;
    if (late_check ? (t - limits.planned) % kLateCheckEvery != 0 : t % kCheckEvery != 0) return false;
    const bool stuck =
        late_check ? in_shape && deviation > kLateStuck * before : near && deviation > limits.stuck * before;
    before = deviation;
    return stuck || (!late_check && deviation < limits.near);
}

}  // namespace hexrelief::step
