// Balancing: what an iteration takes from the sums of the one before: the weight to hold, how early triangles
// resist, and whether it is worth going on.
#pragma once

#include <cstdint>

#include "mesher/steps/balance.h"

namespace hexrelief::step {

inline constexpr int kWeightBits = 32;                  // of weights as integers, whose sums no order changes
inline constexpr int kCheckEvery = 4;                   // iterations between two looks at the deviation
inline constexpr float kFar = 0.05f;                    // above, the number of iterations is not the limit
inline constexpr int kThinShare = 98, kThinOf = 10000;  // share of the triangles that may be thin
inline constexpr float kThresholdStep = 1.04f;          // of an iteration, up or down

// Over all cells with six neighbours and all triangles.
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

// Whether the smallest angle of the triangle (i, a, b) has a sine below the root of sine2. 0 or 1.
HEXRELIEF_HD int is_thin(const BalanceView& v, int i, int a, int b, float sine2) {
    const float ux = v.x[a] - v.x[i], uy = v.y[a] - v.y[i], wx = v.x[b] - v.x[i], wy = v.y[b] - v.y[i];
    const float zx = wx - ux, zy = wy - uy, area2 = ux * wy - uy * wx;
    const float u = ux * ux + uy * uy, w = wx * wx + wy * wy, z = zx * zx + zy * zy;
    // it lies between the two longer sides, whose product times its sine is twice the area
    return static_cast<int>(area2 * area2 * min_of(u, min_of(w, z)) < sine2 * (u * w * z));
}

// Thin ones of a vertex's two triangles towards the next row, each triangle being one vertex's; of an inner
// one and of any.
HEXRELIEF_HD int thin_inner(const BalanceView& v, int i, const VertexRing& ring) {
    return is_thin(v, i, i + ring.at[0], i + ring.at[1], v.thin_sine2) +
           is_thin(v, i, i + ring.at[1], i + ring.at[2], v.thin_sine2);
}
HEXRELIEF_HD int thin_any(const BalanceView& v, int column, int row) {
    const LatticeView m = lattice_view(v);
    int thin = 0;
    HEXRELIEF_ROLLED
    for (int k = 0; k < 2; ++k) {
        const int a = neighbour(m, column, row, k), b = neighbour(m, column, row, k + 1);
        if (a >= 0 && b >= 0) thin += is_thin(v, row * m.columns + column, a, b, v.thin_sine2);
    }
    return thin;
}

// E at which a triangle counts as too thin, from the iteration before.
HEXRELIEF_HD float next_threshold(const BalanceView& v, std::int64_t thin, float threshold) {
    const std::int64_t triangles = std::int64_t{2} * (v.lattice.columns - 1) * (v.lattice.rows - 1);
    return thin * kThinOf > triangles * kThinShare
               ? max_of(threshold * (1.0f / kThresholdStep), v.least_threshold)
               : min_of(threshold * kThresholdStep, v.most_threshold);
}

// What a level is held to: iterations planned, and at most; the deviation that ends it; the share of the
// deviation at the look before that counts as no progress, unless far from balance.
struct BalanceLimits {
    int planned, most;
    float near, stuck;
};

// Whether the level is done before iteration t > 0. mean_deviation: of iteration t - 1 from `target`;
// before: the share at the look before, kept from call to call, at first a large number.
HEXRELIEF_HD bool is_done(const BalanceLimits& limits, int t, float mean_deviation, float target,
                          float& before) {
    const float deviation = target > 0 ? mean_deviation / target : 0.0f;
    if (t >= limits.planned && deviation < kFar) return true;
    if (t % kCheckEvery != 0) return false;
    const bool stuck = deviation < kFar && deviation > limits.stuck * before;
    before = deviation;
    return stuck || deviation < limits.near;
}

}  // namespace hexrelief::step
