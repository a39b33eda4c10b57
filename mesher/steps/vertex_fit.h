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

// The triangle's part of corner k's equation, `other` = disparities of corners k + 1 and k + 2.
HEXRELIEF_HD void add_corner(const TriangleSums& s, int k, double next, double last, double& diagonal,
                             double& right) {
    if (k == 0) {
        diagonal += s.a00;
        right += s.b0 - s.a01 * next - s.a02 * last;
    } else if (k == 1) {
        diagonal += s.a11;
        right += s.b1 - s.a12 * next - s.a01 * last;
    } else {
        diagonal += s.a22;
        right += s.b2 - s.a02 * next - s.a12 * last;
    }
}

}  // namespace hexrelief::step
