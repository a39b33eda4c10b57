// Balancing: what an iteration takes from the sums of the one before: the weight to hold, how early triangles
// resist, and whether it is worth going on.
#pragma once

#include <cstdint>

#include "mesher/balance/edge_integrals_step.h"

namespace hexrelief::step {

inline constexpr int kWeightBits = 32;                  // of weights as integers, whose sums no order changes
inline constexpr int kCheckEvery = 4;                   // iterations between two looks at the deviation
inline constexpr float kFar = 0.03f;                    // above, the number of iterations is not the limit
inline constexpr int kThinShare = 98, kThinOf = 10000;  // share of the triangles that may be thin
inline constexpr float kThresholdStep = 1.04f;          // of an iteration, up or down

// Of a late iteration, one beyond those planned, where walls are steep (ShapeLimits): smaller steps, none for
// a share of thin triangles from kThinEnough on, or the two would swing.
inline constexpr float kLateThresholdStep = 1.02f;
inline constexpr int kThinEnough = 50;
// The finest level then ends where so many iterations take less than 3 % off the deviation.
inline constexpr int kLateCheckEvery = 20;
inline constexpr float kLateStuck = 0.97f;

// Over all cells with six neighbours, and over the triangles of all vertices.
struct BalanceSums {
    std::int64_t weight, deviation, thin;
};

// A weight as an integer. Weights are at most some thousand times 1, so sums of millions fit.
HEXRELIEF_HD std::int64_t whole_weight(float weight) {
    return static_cast<std::int64_t>(weight * static_cast<float>(std::int64_t{1} << kWeightBits));
}

// Adds a cell, whose weight was to become `target`.
HEXRELIEF_HD void add_cell(float weight, float target, BalanceSums& sums) {
    const float missing = target - weight;
    sums.weight += whole_weight(weight);
    sums.deviation += whole_weight(missing < 0 ? -missing : missing);
}

// The mean of `cells` weights from their sum.
HEXRELIEF_HD float mean_weight(std::int64_t sum, int cells) {
    return static_cast<float>(static_cast<double>(sum) /
                              (static_cast<double>(std::int64_t{1} << kWeightBits) * cells));
}

// Whether more triangles than this share are thin; each counts at its three vertices.
HEXRELIEF_HD bool has_thin(const BalanceView& v, std::int64_t thin, int share) {
    const std::int64_t triangles = std::int64_t{6} * (v.lattice.columns - 1) * (v.lattice.rows - 1);
    return thin * kThinOf > triangles * share;
}

// E at which a triangle counts as too thin, from the iteration before.
HEXRELIEF_HD float next_threshold(const BalanceView& v, std::int64_t thin, bool late, float threshold) {
    const float factor = late ? kLateThresholdStep : kThresholdStep;
    if (has_thin(v, thin, kThinShare)) return max_of(threshold * (1.0f / factor), v.least_threshold);
    if (late && has_thin(v, thin, kThinEnough)) return threshold;
    return min_of(threshold * factor, v.most_threshold);
}

// What a level is held to: iterations planned, and at most; the deviation that ends it; the share of the
// deviation at the look before that counts as no progress, unless far from balance; whether no level follows.
struct BalanceLimits {
    int planned, most;
    float near, stuck;
    bool finest;
};

HEXRELIEF_HD bool is_late(const BalanceLimits& limits, int t) {
    return t >= limits.planned;
}

// Whether the level is done before iteration t > 0. mean_deviation: of iteration t - 1 from `target`;
// in_shape: whether at most kThinShare of its triangles were thin then; before: the share at the look before,
// kept from call to call, at first a large number.
HEXRELIEF_HD bool is_done(const BalanceLimits& limits, int t, float mean_deviation, float target,
                          bool in_shape, float& before) {
    const float deviation = target > 0 ? mean_deviation / target : 0.0f;
    const bool near = deviation < kFar;
    if (is_late(limits, t) && near && (in_shape || !limits.finest)) return true;
    const bool late_look = limits.finest && t > limits.planned;
    if (late_look ? (t - limits.planned) % kLateCheckEvery != 0 : t % kCheckEvery != 0) return false;
    const bool stuck =
        late_look ? in_shape && deviation > kLateStuck * before : near && deviation > limits.stuck * before;
    before = deviation;
    return stuck || (!late_look && deviation < limits.near);
}

}  // namespace hexrelief::step
