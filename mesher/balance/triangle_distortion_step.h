// Balancing: each vertex's own part of an iteration, the distortion of its triangles with gradient and
// Hessian.
#pragma once

#include "mesher/balance/edge_integrals_step.h"

namespace hexrelief::step {

struct ShapeSums {
    float gx = 0, gy = 0, hxx = 0, hxy = 0, hyy = 0;  // gradient and Hessian of the sum of f
    float area2 = 0;
    int thin = 0;  // triangles
};

// What a level's triangles are held against: 1 / E at which one counts as too thin, the sine^2 of the least
// angle wanted, and the wall before that E: (E / threshold)^12, or, where `steep` is 1 and not 0, ^24. A
// steep one leaves all triangles that resist the same angle, but takes longer to get there.
struct ShapeLimits {
    float inverse_threshold, sine2, steep = 0;
};

// Under the same force a steep wall holds a triangle nearer to its threshold, which must begin that much
// earlier.
inline constexpr float kSteepFrom = 1.1f;

HEXRELIEF_HD ShapeLimits shape_limits(const BalanceView& v, float threshold, bool steep) {
    return {(steep ? kSteepFrom : 1.0f) / threshold, v.thin_sine2, steep ? 1.0f : 0.0f};
}

// Whether a triangle of twice this area and these squared sides has a smaller angle: it lies between the two
// longer sides, whose product times its sine is twice the area. 0 or 1.
HEXRELIEF_HD int is_thin(float area2, float u, float v, float w, float sine2) {
    return static_cast<int>(area2 * area2 * min_of(u, min_of(v, w)) < sine2 * (u * v * w));
}

// Adds the triangle (p, a, b), counter-clockwise, as a function of p.
HEXRELIEF_HD void add_triangle(const ShapeLimits& limits, float px, float py, float ax, float ay, float bx,
                               float by, ShapeSums& sums) {
    const float c = 0.28867513f;  // 1 / (2 sqrt 3)
    const float ux = ax - px, uy = ay - py, vx = bx - px, vy = by - py, wx = bx - ax, wy = by - ay;
    const float area2 = max_of(ux * vy - uy * vx, kLeastBalanceArea2_px);
    const float inverse = 1.0f / area2;
    const float u_square = ux * ux + uy * uy, v_square = vx * vx + vy * vy, w_square = wx * wx + wy * wy;
    const float distortion = c * (u_square + v_square + w_square) * inverse;
    const float inverse_threshold = limits.inverse_threshold, scale = inverse * inverse_threshold;
    // The wall goes by the smallest angle: u = 1 / (sqrt(3) x its sine), from the product of the two longer
    // sides over twice the area. In a sliver that is E; in a flat triangle, whose smallest angle is half as
    // large again as that of the sliver of the same E, 2/3 of E, which the derivatives take as constant.
    const float longer = max_of(u_square * v_square, max_of(v_square * w_square, w_square * u_square));
    const float u2 = min_of(4.0f * c * c * longer * (scale * scale), 16.0f);
    const float u4 = u2 * u2, u10 = u4 * u4 * u2;
    const float power = 12.0f + 12.0f * limits.steep;  // no branch, or rows of vertices run one by one
    const float wall = power * u10 * (limits.steep * (u10 * u2) + (1.0f - limits.steep)) * inverse_threshold;
    const float first = kEvenness + wall * min_of(distortion * inverse_threshold, 4.0f);
    const float second = (power - 1.0f) * wall * inverse_threshold;
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

// Writes H^-1 (given), the reach, and the shape's step from the sums over `triangles` triangles.
HEXRELIEF_HD void write_shape(const BalanceView& v, int i, const ShapeSums& s, float triangles, float xx,
                              float xy, float yy) {
    const float dx = -(xx * s.gx + xy * s.gy), dy = -(xy * s.gx + yy * s.gy);
    const float mean_area2 = s.area2 / triangles;
    const float longest2 = kShapeReach * kShapeReach * mean_area2;
    const float shrunk = sqrtf(longest2 / max_of(dx * dx + dy * dy, longest2));
    v.inverse_xx[i] = xx;
    v.inverse_xy[i] = xy;
    v.inverse_yy[i] = yy;
    v.reach[i] = sqrtf(mean_area2);
    v.step_x[i] = dx * shrunk;
    v.step_y[i] = dy * shrunk;
}

HEXRELIEF_HD float least_determinant(const ShapeSums& s) {
    return max_of(s.hxx * s.hyy - s.hxy * s.hxy, 1e-6f * s.hxx * s.hyy);
}

// For a vertex with six neighbours; free of branches, so that rows of them run in vector registers. Returns
// how many of its triangles are thin.
HEXRELIEF_HD int shape_inner(const BalanceView& v, int i, const ShapeLimits& limits, const VertexRing& ring) {
    const float x = v.x[i], y = v.y[i];
    float rx[6], ry[6];
    HEXRELIEF_UNROLL
    for (int k = 0; k < 6; ++k) {
        rx[k] = v.x[i + ring.at[k]];
        ry[k] = v.y[i + ring.at[k]];
    }
    ShapeSums s;
    add_triangle(limits, x, y, rx[0], ry[0], rx[1], ry[1], s);
    add_triangle(limits, x, y, rx[1], ry[1], rx[2], ry[2], s);
    add_triangle(limits, x, y, rx[2], ry[2], rx[3], ry[3], s);
    add_triangle(limits, x, y, rx[3], ry[3], rx[4], ry[4], s);
    add_triangle(limits, x, y, rx[4], ry[4], rx[5], ry[5], s);
    add_triangle(limits, x, y, rx[5], ry[5], rx[0], ry[0], s);
    const float inverse = 1.0f / least_determinant(s);
    write_shape(v, i, s, 6.0f, s.hyy * inverse, -s.hxy * inverse, s.hxx * inverse);
    return s.thin;
}

// For any vertex, with the same bits; in a loop that is not unrolled, for a device.
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
            add_triangle(limits, x, y, v.x[a], v.y[a], v.x[b], v.y[b], s);
            triangles += 1.0f;
        }
        a = b;
    }
    const bool hold_x = v.pinned && (column == 0 || column == m.columns - 1);
    const bool hold_y = v.pinned && (row == 0 || row == m.rows - 1);
    if (hold_y && !hold_x && is_bent(v.outline)) {  // along the curve alone
        const float slope = curve_slope(v.outline, curve_of(v.outline, row), x);
        const float inverse = 1.0f / (s.hxx + slope * (2.0f * s.hxy + slope * s.hyy));
        write_shape(v, i, s, triangles, inverse, slope * inverse, slope * slope * inverse);
    } else if (hold_x || hold_y) {
        write_shape(v, i, s, triangles, hold_x ? 0.0f : 1.0f / s.hxx, 0.0f, hold_y ? 0.0f : 1.0f / s.hyy);
    } else {
        const float inverse = 1.0f / least_determinant(s);
        write_shape(v, i, s, triangles, s.hyy * inverse, -s.hxy * inverse, s.hxx * inverse);
    }
    return s.thin;
}

}  // namespace hexrelief::step
