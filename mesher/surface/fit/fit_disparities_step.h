// Fits a piecewise linear surface to the pixels of each triangle's own label by least squares.
#pragma once

#include <cstdint>

#include "mesher/common/surface_thresholds_step.h"
#include "mesher/surface/pixels/discontinuities_step.h"
#include "pipeline/base/host_device.h"
#include "pipeline/data/geometry.h"

namespace hexrelief::step {

// Sums over pixels by column x, row y and disparity d. Sums of whole numbers are exact in doubles.
struct Moments {
    double n = 0, x = 0, y = 0, xx = 0, xy = 0, yy = 0, d = 0, xd = 0, yd = 0;
};

// Adds n and the sums of x, y, xx, xy and yy of pixels first .. end - 1 of a row.
HEXRELIEF_HD void add_run(Moments& m, int row, int first, int end) {
    const auto squares_below = [](std::int64_t k) { return (k - 1) * k * (2 * k - 1) / 6; };
    const std::int64_t n = end - first, x = (std::int64_t{first} + end - 1) * n / 2;
    m.n += static_cast<double>(n);
    m.x += static_cast<double>(x);
    m.y += static_cast<double>(n * row);
    m.xx += static_cast<double>(squares_below(end) - squares_below(first));
    m.xy += static_cast<double>(x * row);
    m.yy += static_cast<double>(n * row * row);
}
// Adds the sums of d, xd and yd of one pixel.
HEXRELIEF_HD void add_disparity(Moments& m, double x, double y, float disparity) {
    const double d = disparity;
    m.d += d;
    m.xd += x * d;
    m.yd += y * d;
}

// Adds all sums of one pixel.
HEXRELIEF_HD void add_pixel(Moments& m, double x, double y, float disparity) {
    m.n += 1;
    m.x += x;
    m.y += y;
    m.xx += x * x;
    m.xy += x * y;
    m.yy += y * y;
    add_disparity(m, x, y, disparity);
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
}

// Returns the same moments with x and y counted from a pixel near the summed ones, which
// keeps whole numbers exact.
HEXRELIEF_HD Moments from_pixel(const Moments& m, double column, double row) {
    const double x = m.x - m.n * column, y = m.y - m.n * row;
    return {m.n,
            x,
            y,
            m.xx - column * (m.x + x),
            m.xy - column * m.y - row * x,
            m.yy - row * (m.y + y),
            m.d,
            m.xd - column * m.d,
            m.yd - row * m.d};
}

// True if the pixels are enough for a plane and not all in a row.
HEXRELIEF_HD bool holds_plane(const Moments& m) {
    if (m.n < kPlaneLeastPixels) return false;
    const double xx = m.xx - m.x * m.x / m.n, xy = m.xy - m.x * m.y / m.n, yy = m.yy - m.y * m.y / m.n;
    return xx * yy - xy * xy > kPlaneLeastWidth * (xx + yy) * (xx + yy) && xx + yy > kPlaneLeastSpread_px2;
}

// Returns the disparity of the fitted plane at (x, y) px, x and y >= 0; the pixels' mean if they hold no
// plane. Requires n > 0.
HEXRELIEF_HD double plane_at(const Moments& moments, float x, float y) {
    const double column = static_cast<double>(static_cast<int>(x)),
                 row = static_cast<double>(static_cast<int>(y));
    const Moments m = from_pixel(moments, column, row);
    double gx = 0, gy = 0;
    if (holds_plane(m)) {
        const double xx = m.xx - m.x * m.x / m.n, xy = m.xy - m.x * m.y / m.n, yy = m.yy - m.y * m.y / m.n;
        const double xd = m.xd - m.x * m.d / m.n, yd = m.yd - m.y * m.d / m.n;
        const double determinant = xx * yy - xy * xy;
        gx = (xd * yy - yd * xy) / determinant;
        gy = (yd * xx - xd * xy) / determinant;
    }
    return m.d / m.n + gx * (static_cast<double>(x) - column - 0.5 - m.x / m.n) +
           gy * (static_cast<double>(y) - row - 0.5 - m.y / m.n);
}

HEXRELIEF_HD float squared_length(const Vec2f& a, const Vec2f& b) {
    const float dx = b.x - a.x, dy = b.y - a.y;
    return dx * dx + dy * dy;
}

// Returns the least disparity of a vertex. Planes extend beyond their pixels; half of the smallest valid
// disparity keeps them from running off to infinity.
HEXRELIEF_HD double lowest_disparity(float smallest) {
    return max_of(kLowestDisparity_px, 0.5 * static_cast<double>(smallest));
}

// One triangle's contribution to the normal equations, with its pixels' barycentric coordinates l and weights
// w: sums of w l_k l_k (own), of w l_k l_k+1 (cross) and of w l_k d (right).
struct TriangleSums {
    double own[3]{}, cross[3]{}, right[3]{};
};

// A triangle with corners a, b, c: the position of a, the sides ab and ac, and twice the area.
struct PlanePatch {
    double x, y, abx, aby, acx, acy, area;
};

HEXRELIEF_HD PlanePatch plane_patch(float ax, float ay, float bx, float by, float cx, float cy) {
    PlanePatch p{ax, ay, double(bx) - ax, double(by) - ay, double(cx) - ax, double(cy) - ay, 0};
    p.area = p.abx * p.acy - p.aby * p.acx;
    return p;
}

// Gives the barycentric coordinates of a pixel's centre for corners b (l1) and c (l2).
HEXRELIEF_HD void pixel_shares(const PlanePatch& p, double column, double row, double& l1, double& l2) {
    const double x = column + 0.5 - p.x, y = row + 0.5 - p.y;
    l1 = (x * p.acy - y * p.acx) / p.area;
    l2 = (p.abx * y - p.aby * x) / p.area;
}

// Returns a pixel's weight in the fit.
HEXRELIEF_HD double fit_weight(const PixelView& view, int x, int y) {
    return is_behind_low_half_occlusion(view, x, y) ? kHalfOcclusionWeight : 1.0;
}

// Adds a pixel with barycentric coordinates l0, l1, l2, disparity d and weight w.
HEXRELIEF_HD void add_pixel(TriangleSums& s, double l0, double l1, double l2, double d, double w) {
    s.own[0] += w * l0 * l0;
    s.own[1] += w * l1 * l1;
    s.own[2] += w * l2 * l2;
    s.cross[0] += w * l0 * l1;
    s.cross[1] += w * l1 * l2;
    s.cross[2] += w * l0 * l2;
    s.right[0] += w * l0 * d;
    s.right[1] += w * l1 * d;
    s.right[2] += w * l2 * d;
}

// Row k of one triangle's normal equations, with the corners counted from k on.
struct CornerRow {
    double own, next, last, right;
};

HEXRELIEF_HD CornerRow corner_row(const TriangleSums& s, unsigned k) {
    return {s.own[k], s.cross[k], s.cross[(k + 2) % 3], s.right[k]};
}

// Returns the row's part of the right-hand side of corner k's equation, with the other two
// corners at these disparities.
HEXRELIEF_HD double right_side(const CornerRow& row, double next, double last) {
    return row.right - row.next * next - row.last * last;
}

// Returns a vertex's value after a damped Jacobi step towards diagonal * value = right, at least `least`.
HEXRELIEF_HD double relaxed(double value, double right, double diagonal, double least) {
    return max_of(value + kFitDamping * (right / diagonal - value), least);
}

}  // namespace hexrelief::step
