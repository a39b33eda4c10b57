// Least-squares fit of a piecewise linear surface to the pixels of its own side.
#pragma once

#include <cstddef>

#include "mesher/steps/host_device.h"

namespace hexrelief::step {

// Of pixels at their centres; whole-number sums stay exact in doubles.
struct Moments {
    double n = 0, x = 0, y = 0, xx = 0, xy = 0, yy = 0, d = 0, xd = 0, yd = 0;
    float least = 3.0e38f, most = -3.0e38f;
};

HEXRELIEF_HD void add_pixel(Moments& m, int column, int row, float disparity) {
    const double x = column, y = row, d = disparity;
    m.n += 1;
    m.x += x;
    m.y += y;
    m.xx += x * x;
    m.xy += x * y;
    m.yy += y * y;
    m.d += d;
    m.xd += x * d;
    m.yd += y * d;
    m.least = min_of(m.least, disparity);
    m.most = max_of(m.most, disparity);
}

HEXRELIEF_HD void add_moments(Moments& m, const Moments& o) {
    m.n += o.n;
    m.x += o.x;
    m.y += o.y;
    m.xx += o.xx;
    m.xy += o.xy;
    m.yy += o.yy;
    m.d += o.d;
    m.xd += o.xd;
    m.yd += o.yd;
    m.least = min_of(m.least, o.least);
    m.most = max_of(m.most, o.most);
}

// Enough pixels, and not all in a row, for a plane.
HEXRELIEF_HD bool holds_plane(const Moments& m) {
    if (m.n < 6) return false;
    const double xx = m.xx - m.x * m.x / m.n, xy = m.xy - m.x * m.y / m.n, yy = m.yy - m.y * m.y / m.n;
    return xx * yy - xy * xy > 0.05 * (xx + yy) * (xx + yy) && xx + yy > 2;
}

// The plane's disparity at (x, y) px, kept within `reach` px beyond the pixels' range; their mean where they
// hold no plane. n > 0.
HEXRELIEF_HD double plane_at(const Moments& m, float x, float y, float reach) {
    double gx = 0, gy = 0;
    if (holds_plane(m)) {
        const double xx = m.xx - m.x * m.x / m.n, xy = m.xy - m.x * m.y / m.n, yy = m.yy - m.y * m.y / m.n;
        const double xd = m.xd - m.x * m.d / m.n, yd = m.yd - m.y * m.d / m.n;
        const double determinant = xx * yy - xy * xy;
        gx = (xd * yy - yd * xy) / determinant;
        gy = (yd * xx - xd * xy) / determinant;
    }
    const double at = m.d / m.n + gx * (static_cast<double>(x) - 0.5 - m.x / m.n) +
                      gy * (static_cast<double>(y) - 0.5 - m.y / m.n);
    return clamp_to(at, static_cast<double>(m.least) - reach, static_cast<double>(m.most) + reach);
}

// One triangle's share of the normal equations: sum of w l l^T and w l d over its pixels, l barycentric.
struct TriangleSums {
    double a00 = 0, a11 = 0, a22 = 0, a01 = 0, a02 = 0, a12 = 0, b0 = 0, b1 = 0, b2 = 0;
};

// Huber's weight: residuals beyond `tolerance` count less.
HEXRELIEF_HD double huber_weight(double residual, double tolerance) {
    const double size = residual < 0 ? -residual : residual;
    return size > tolerance ? tolerance / size : 1.0;
}

// A triangle with disparities d0, d0 + d1, d0 + d2 at its corners a, b, c.
struct PlanePatch {
    double x, y, abx, aby, acx, acy, area, d0, d1, d2;
};

HEXRELIEF_HD PlanePatch plane_patch(float ax, float ay, float bx, float by, float cx, float cy, double da,
                                    double db, double dc) {
    PlanePatch p{ax, ay, double(bx) - ax, double(by) - ay, double(cx) - ax, double(cy) - ay,
                 0,  da, db - da,         dc - da};
    p.area = p.abx * p.acy - p.aby * p.acx;
    return p;
}

// A pixel's shares of corners b and c, and its weight.
HEXRELIEF_HD void weigh_pixel(const PlanePatch& p, double column, double row, double d, double tolerance,
                              double& l1, double& l2, double& weight) {
    const double x = column + 0.5 - p.x, y = row + 0.5 - p.y;
    l1 = (x * p.acy - y * p.acx) / p.area;
    l2 = (p.abx * y - p.aby * x) / p.area;
    weight = huber_weight(p.d0 + l1 * p.d1 + l2 * p.d2 - d, tolerance);
}

HEXRELIEF_HD void add_pixel(TriangleSums& s, double l0, double l1, double l2, double d, double w) {
    s.a00 += w * l0 * l0;
    s.a11 += w * l1 * l1;
    s.a22 += w * l2 * l2;
    s.a01 += w * l0 * l1;
    s.a02 += w * l0 * l2;
    s.a12 += w * l1 * l2;
    s.b0 += w * l0 * d;
    s.b1 += w * l1 * d;
    s.b2 += w * l2 * d;
}

// Row k of one triangle's normal equations, its corners counted from k on.
struct CornerRow {
    double own, next, last, right;
};

HEXRELIEF_HD CornerRow corner_row(const TriangleSums& s, int k) {
    if (k == 0) return {s.a00, s.a01, s.a02, s.b0};
    if (k == 1) return {s.a11, s.a12, s.a01, s.b1};
    return {s.a22, s.a02, s.a12, s.b2};
}

// Its part of the equation of vertex k, the other two at these disparities.
HEXRELIEF_HD double right_side(const CornerRow& row, double next, double last) {
    return row.right - row.next * next - row.last * last;
}

}  // namespace hexrelief::step
