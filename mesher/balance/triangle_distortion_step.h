// Balancing: the distortion of each vertex's triangles, with its gradient and Hessian.
#pragma once

#include <cmath>

#include "mesher/balance/edge_integrals_step.h"

namespace hexrelief::step {

// Sums over the triangles of a vertex.
struct ShapeSums {
    float gx = 0, gy = 0, hxx = 0, hxy = 0, hyy = 0;  // gradient and Hessian of the sum of f
    // Sum of twice the areas.
    float area2 = 0;
    int thin = 0;  // number of thin triangles
};

// Limits of a level's triangle shapes: 1 / the E above which a triangle counts as too thin, and sine^2 of the
// smallest angle wanted. The penalty grows as (E / threshold)^12 if `steep` is 0, as ^24 if it is 1. With a
// steep penalty all triangles that resist end at about the same angle, but it takes longer.
struct ShapeLimits {
    float inverse_threshold, sine2, steep = 0;
};

// With the same force a steep penalty lets a triangle come nearer to the threshold, which is
// therefore divided by this.
inline constexpr float kSteepFrom = 1.1f;

HEXRELIEF_HD ShapeLimits shape_limits(const BalanceView& v, float threshold, bool steep) {
    return {(steep ? kSteepFrom : 1.0f) / threshold, v.thin_sine2, steep ? 1.0f : 0.0f};
}

// Returns 1 if sine^2 of the triangle's smallest angle is below `sine2`, else 0. area2: twice its area;
// u, v, w: its squared sides. The smallest angle lies between the two longer sides, whose product times
// its sine is area2.
HEXRELIEF_HD int is_thin(float area2, float u, float v, float w, float sine2) {
    return static_cast<int>(area2 * area2 * min_of(u, min_of(v, w)) < sine2 * (u * v * w));
}

// Adds the counter-clockwise triangle (p, a, b), whose distortion is taken as a function of p.
HEXRELIEF_HD void add_triangle(const ShapeLimits& limits, const Position& p, const Position& a,
                               const Position& b, ShapeSums& sums) {
    const float c = 0.28867513f;  // 1 / (2 sqrt 3)
    const float ux = a.x - p.x, uy = a.y - p.y, vx = b.x - p.x, vy = b.y - p.y, wx = b.x - a.x,
                wy = b.y - a.y;
    const float area2 = max_of(ux * vy - uy * vx, kLeastBalanceArea2_px);
    const float inverse = 1.0f / area2;
    const float u_square = ux * ux + uy * uy, v_square = vx * vx + vy * vy, w_square = wx * wx + wy * wy;
    const float distortion = c * (u_square + v_square + w_square) * inverse;
    const float inverse_threshold = limits.inverse_threshold, scale = inverse * inverse_threshold;
    // The penalty depends on the smallest angle: u = 1 / (sqrt(3) x its sine), from the product of the two
    // longer sides over twice the area. In a triangle with one short side u equals E. A triangle with an
    // angle near 180 degrees has a smallest angle 1.5 times as large for the same E, and there u is 2/3 E;
    // the derivatives take this factor as constant.
    const float longer = max_of(u_square * v_square, max_of(v_square * w_square, w_square * u_square));
    const float u2 = min_of(4.0f * c * c * longer * (scale * scale), 16.0f);
    const float u4 = u2 * u2, u10 = u4 * u4 * u2;
    const float power = 12.0f + 12.0f * limits.steep;  // without a branch, so that rows of vertices vectorise
    const float penalty =
        power * u10 * (limits.steep * (u10 * u2) + (1.0f - limits.steep)) * inverse_threshold;
    const float first = kEvenness + penalty * min_of(distortion * inverse_threshold, 4.0f);
    const float second = (power - 1.0f) * penalty * inverse_threshold;
    const float ex = (distortion * wy - 2.0f * c * (ux + vx)) * inverse;
    const float ey = (-distortion * wx - 2.0f * c * (uy + vy)) * inverse;
    const float k = first * inverse;
    sums.gx += first * ex;
    sums.gy += first * ey;
    sums.hxx += k * (4.0f * c + 2.0f * ex * wy) + second * ex * ex;
    sums.hxy += k * (ey * wy - ex * wx) + second * ex * ey;
    sums.hyy += k * (4.0f * c - 2.0f * ey * wx) + second * ey * ey;
    sums.area2 += area2;
    sums.thin += is_thin(area2, u_square, v_square, w_square, limits.sine2);
}

// A symmetric 2 x 2 matrix.
struct Symmetric {
    float xx, xy, yy;
};

// Writes H^-1, the reach, and the step for shape, from sums over `triangles` triangles.
HEXRELIEF_HD void write_shape(const BalanceView& v, int i, const ShapeSums& s, float triangles,
                              const Symmetric& inverse) {
    const float dx = -(inverse.xx * s.gx + inverse.xy * s.gy), dy = -(inverse.xy * s.gx + inverse.yy * s.gy);
    const float mean_area2 = s.area2 / triangles;
    const float longest2 = kShapeReach * kShapeReach * mean_area2;
    const float shrunk = sqrtf(longest2 / max_of(dx * dx + dy * dy, longest2));
    v.inverse_xx[i] = inverse.xx;
    v.inverse_xy[i] = inverse.xy;
    v.inverse_yy[i] = inverse.yy;
    v.reach[i] = sqrtf(mean_area2);
    v.step_x[i] = dx * shrunk;
    v.step_y[i] = dy * shrunk;
}

// Fixes a vertex in place; to be called after write_shape().
HEXRELIEF_HD void hold_vertex(const BalanceView& v, int i) {
    v.inverse_xx[i] = v.inverse_xy[i] = v.inverse_yy[i] = 0.0f;
    v.step_x[i] = v.step_y[i] = 0.0f;
}

// Returns the Hessian's determinant, bounded from below so that it stays invertible.
HEXRELIEF_HD float least_determinant(const ShapeSums& s) {
    return max_of(s.hxx * s.hyy - s.hxy * s.hxy, 1e-6f * s.hxx * s.hyy);
}

// Writes the shape of a vertex with six neighbours; without branches, so that rows of vertices vectorise.
// Returns the number of its thin triangles.
HEXRELIEF_HD int shape_inner(const BalanceView& v, int i, const ShapeLimits& limits, const VertexRing& ring) {
    const Position p{v.x[i], v.y[i]};
    Position around[6];
    HEXRELIEF_UNROLL
    for (int k = 0; k < 6; ++k) around[k] = {v.x[i + ring.at[k]], v.y[i + ring.at[k]]};
    ShapeSums s;
    add_triangle(limits, p, around[0], around[1], s);
    add_triangle(limits, p, around[1], around[2], s);
    add_triangle(limits, p, around[2], around[3], s);
    add_triangle(limits, p, around[3], around[4], s);
    add_triangle(limits, p, around[4], around[5], s);
    add_triangle(limits, p, around[5], around[0], s);
    const float inverse = 1.0f / least_determinant(s);
    write_shape(v, i, s, 6.0f, {s.hyy * inverse, -s.hxy * inverse, s.hxx * inverse});
    return s.thin;
}

// Does the same for any vertex, with the same bits as shape_inner(), in a loop that is not
// unrolled on a device.
HEXRELIEF_HD int shape_of(const BalanceView& v, int column, int row, const ShapeLimits& limits) {
    const LatticeView m = lattice_view(v);
    const int i = row * m.columns + column;
    const float x = v.x[i], y = v.y[i];
    ShapeSums s;
    float triangles = 0;
    int a = neighbour(m, column, row, 0);
    HEXRELIEF_ROLLED
    for (int k = 1; k <= 6; ++k) {
        const int b = neighbour(m, column, row, k < 6 ? k : 0);
        if (a >= 0 && b >= 0) {
            add_triangle(limits, {x, y}, {v.x[a], v.y[a]}, {v.x[b], v.y[b]}, s);
            triangles += 1.0f;
        }
        a = b;
    }
    const bool hold_x = v.pinned && (column == 0 || column == m.columns - 1);
    const bool hold_y = v.pinned && (row == 0 || row == m.rows - 1);
    if (hold_y && !hold_x && is_bent(v.outline)) {  // moves only along the curve
        const float slope = curve_slope(v.outline, curve_of(v.outline, row), x);
        const float inverse = 1.0f / (s.hxx + slope * (2.0f * s.hxy + slope * s.hyy));
        write_shape(v, i, s, triangles, {inverse, slope * inverse, slope * slope * inverse});
    } else if (hold_x || hold_y) {
        write_shape(v, i, s, triangles, {hold_x ? 0.0f : 1.0f / s.hxx, 0.0f, hold_y ? 0.0f : 1.0f / s.hyy});
    } else {
        const float inverse = 1.0f / least_determinant(s);
        write_shape(v, i, s, triangles, {s.hyy * inverse, -s.hxy * inverse, s.hxx * inverse});
    }
    return s.thin;
}

}  // namespace hexrelief::step
