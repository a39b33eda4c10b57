// Balancing: the end of an iteration. Its sums give the target weight and the triangle threshold of the next,
// and tell whether the level is done; each vertex's step is proposed, shrunk until it leaves no triangle
// folded or too thin, and taken.
#pragma once

#include <cmath>
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

// Computes the vertex's whole step, limited to its reach.
HEXRELIEF_HD void propose_step(const BalanceView& v, int column, int row) {
    const int i = row * v.lattice.columns + column, of_class = honeycomb_class(column, row);
    float dx = v.step_x[i], dy = v.step_y[i];
    if (of_class != 0) {
        float x = 0, y = 0;
        for (int j = 0; j < 3; ++j) {
            const Neighbour cell = neighbour_of(v, column, row, cell_direction(of_class, j));
            if (!cell.exists) continue;
            const float force = v.multiplier[cell_slot(v, cell.column, cell.row)];
            x += v.gradient_x[3 * i + j] * force;
            y += v.gradient_y[3 * i + j] * force;
        }
        dx += v.inverse_xx[i] * x + v.inverse_xy[i] * y;
        dy += v.inverse_xy[i] * x + v.inverse_yy[i] * y;
    }
    const float longest = kReach * v.reach[i], length = sqrtf(dx * dx + dy * dy);
    const float scale = length > longest ? longest / length : 1.0f;
    const bool sound = length * scale <= longest * 1.01f;  // false if the length is NaN
    v.step_x[i] = sound ? dx * scale : 0.0f;
    v.step_y[i] = sound ? dy * scale : 0.0f;
    if (is_bent(v.outline) && is_end(v.lattice, row)) {
        const float x = clamp_to(v.x[i] + v.step_x[i], 0.0f, v.extent_x);
        v.step_y[i] = curve_at(v.outline, curve_of(v.outline, row), x) - v.y[i];
    }
    v.scale[i] = 1.0f;
}

// Proposes the last step of the finest level if its first and last rows are bent: the edges of these rows
// move outwards until they enclose the whole region between the curves.
HEXRELIEF_HD void propose_lift(const BalanceView& v, int column, int row) {
    const int i = row * v.lattice.columns + column;
    float lift = 0;
    if (is_end(v.lattice, row)) {
        if (column > 0) lift = cut_off(v.outline, row, {v.x[i - 1], v.y[i - 1]}, {v.x[i], v.y[i]});
        if (column + 1 < v.lattice.columns)
            lift = max_of(lift, cut_off(v.outline, row, {v.x[i], v.y[i]}, {v.x[i + 1], v.y[i + 1]}));
    }
    v.step_x[i] = 0.0f;
    v.step_y[i] = row == 0 ? -lift : lift;
    v.scale[i] = 1.0f;
}

// Returns 1 if the scaled steps would spoil the triangle of vertices i, a, b (make it folded or
// too thin), else 0.
HEXRELIEF_HD int spoils(const BalanceView& v, int i, int a, int b) {
    const float ux = v.x[a] - v.x[i], uy = v.y[a] - v.y[i], wx = v.x[b] - v.x[i], wy = v.y[b] - v.y[i];
    const float mx = v.step_x[i] * v.scale[i], my = v.step_y[i] * v.scale[i];
    const float tx = ux + (v.step_x[a] * v.scale[a] - mx), ty = uy + (v.step_y[a] * v.scale[a] - my);
    const float sx = wx + (v.step_x[b] * v.scale[b] - mx), sy = wy + (v.step_y[b] * v.scale[b] - my);
    const float zx = sx - tx, zy = sy - ty, after = tx * sy - ty * sx;
    const float thin = kThinStep * ((tx * tx + ty * ty) + (sx * sx + sy * sy) + (zx * zx + zy * zy));
    return static_cast<int>(after < thin) &
           static_cast<int>(after < kLeastRemainingShare * (ux * wy - uy * wx));
}

// Returns 1 if the steps would spoil one of the triangles of a vertex with six neighbours, else 0.
HEXRELIEF_HD int spoils_inner(const BalanceView& v, int i, const VertexRing& ring) {
    return spoils(v, i, i + ring.at[0], i + ring.at[1]) | spoils(v, i, i + ring.at[1], i + ring.at[2]) |
           spoils(v, i, i + ring.at[2], i + ring.at[3]) | spoils(v, i, i + ring.at[3], i + ring.at[4]) |
           spoils(v, i, i + ring.at[4], i + ring.at[5]) | spoils(v, i, i + ring.at[5], i + ring.at[0]);
}

// Returns the same for any vertex, in a loop that is not unrolled.
HEXRELIEF_HD int spoils_any(const BalanceView& v, int column, int row) {
    const LatticeView m = lattice_view(v);
    int any = 0, a = neighbour(m, column, row, 5);
    HEXRELIEF_ROLLED
    for (int k = 0; k < 6; ++k) {
        const int b = neighbour(m, column, row, k);
        if (a >= 0 && b >= 0) any |= spoils(v, row * m.columns + column, a, b);
        a = b;
    }
    return any;
}

// Returns the factor by which a round shrinks the step of a vertex that spoils a triangle.
HEXRELIEF_HD float shrink_factor(int round) {
    return round < kShrinkRounds / 2 ? 0.5f : 0.0f;
}

// Moves a vertex by its scaled step. on_curve: vertices of bent first and last rows stay on their
// curves; false after propose_lift().
HEXRELIEF_HD void take_step(const BalanceView& v, int i, bool on_curve) {
    v.x[i] = clamp_to(v.x[i] + v.step_x[i] * v.scale[i], 0.0f, v.extent_x);
    v.y[i] = clamp_to(v.y[i] + v.step_y[i] * v.scale[i], 0.0f, v.extent_y);
    if (!on_curve || !is_bent(v.outline)) return;
    const int last = (v.lattice.rows - 1) * v.lattice.columns;
    if (i < v.lattice.columns) v.y[i] = curve_at(v.outline, v.outline.upper, v.x[i]);
    if (i >= last) v.y[i] = curve_at(v.outline, v.outline.lower, v.x[i]);
}

}  // namespace hexrelief::step
