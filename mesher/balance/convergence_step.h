// Balancing: what follows from the sums of one iteration for the next: the target weight, the threshold from
// which on triangles resist, and whether to go on.
#pragma once

#include <cstdint>

#include "mesher/balance/edge_integrals_step.h"

namespace hexrelief::step {

inline constexpr int kWeightBits = 32;  // of weights as integers, whose sums do not depend on the order
inline constexpr int kCheckEvery = 4;   // iterations between two checks of the deviation
inline constexpr float kFar = 0.03f;    // relative deviation above which a level counts as far from balance
inline constexpr int kThinShare = 98, kThinOf = 10000;  // share of the triangles that may be thin
inline constexpr float kThresholdStep = 1.04f;          // of an iteration, up or down

// For late iterations, those beyond the planned ones, whose penalty is steep (ShapeLimits): a smaller factor,
// and 1 for shares of thin triangles between kThinEnough and kThinShare, or share and threshold would
// oscillate.
inline constexpr float kLateThresholdStep = 1.02f;
inline constexpr int kThinEnough = 50;
// The finest level ends where kLateCheckEvery late iterations lower the deviation by less than 3 %.
inline constexpr int kLateCheckEvery = 20;
inline constexpr float kLateStuck = 0.97f;

// Over all cells with six neighbours, and over the triangles of all vertices.
struct BalanceSums {
    std::int64_t weight, deviation, thin;
};

// A weight as an integer. Weights are at most some thousands, so sums of millions of them fit 64 bits.
HEXRELIEF_HD std::int64_t whole_weight(float weight) {
    return static_cast<std::int64_t>(weight * static_cast<float>(std::int64_t{1} << kWeightBits));
}

// Adds a cell of this weight, which is held to `target`.
HEXRELIEF_HD void add_cell(float weight, float target, BalanceSums& sums) {
    const float missing = target - weight;
    sums.weight += whole_weight(weight);
    sums.deviation += whole_weight(missing < 0 ? -missing : missing);
}

// The mean of `cells` weights, from the sum of their integers.
HEXRELIEF_HD float mean_weight(std::int64_t sum, int cells) {
    return static_cast<float>(static_cast<double>(sum) /
                              (static_cast<double>(std::int64_t{1} << kWeightBits) * cells));
}

// Whether more than share / kThinOf of all triangles are thin; `thin` counts each at its three vertices.
HEXRELIEF_HD bool has_thin(const BalanceView& v, std::int64_t thin, int share) {
    const std::int64_t triangles = std::int64_t{6} * (v.lattice.columns - 1) * (v.lattice.rows - 1);
    return thin * kThinOf > triangles * share;
}

// The next iteration's E at which a triangle counts as too thin.
HEXRELIEF_HD float next_threshold(const BalanceView& v, std::int64_t thin, bool late, float threshold) {
    const float factor = late ? kLateThresholdStep : kThresholdStep;
    if (has_thin(v, thin, kThinShare)) return max_of(threshold * (1.0f / factor), v.least_threshold);
    if (late && has_thin(v, thin, kThinEnough)) return threshold;
    return min_of(threshold * factor, v.most_threshold);
}

// When a level ends. planned, most: its iterations; near: the relative deviation that is good enough; stuck:
// the share of the deviation at the check before from which on there is no progress, unless far from balance.
struct BalanceLimits {
    int planned, most;
    float near, stuck;
    bool finest;  // no level follows
};

HEXRELIEF_HD bool is_late(const BalanceLimits& limits, int t) {
    return t >= limits.planned;
}

// Whether the level is done before iteration t > 0. mean_deviation: of the weights of iteration t - 1 from
// `target`; in_shape: whether at most kThinShare of its triangles were thin. before: the relative deviation
// at the check before, kept from call to call; at first a large number.
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
