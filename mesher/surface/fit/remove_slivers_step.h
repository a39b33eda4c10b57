// Small triangles that span a step which their surface does not have: slivers in space.
#pragma once

#include "mesher/common/host_device.h"
#include "mesher/common/surface_thresholds_step.h"
#include "pipeline/data/geometry.h"

namespace hexrelief::step {

// Whether a small triangle with disparities da, db, dc rises by more than a discontinuity, and so steeply
// that the two cameras could not both see it. Larger ones stay: the holes that they would leave cost more
// than they do (duo_rmse_near_px of teddy without them 0.41 -> 1.05, of cones 0.40 -> 0.55; with the limit
// 0.41 and 0.40).
HEXRELIEF_HD bool is_sliver(const Vec2f& a, const Vec2f& b, const Vec2f& c, double da, double db, double dc,
                            double discontinuity_px) {
    const auto size = [](double value) { return value < 0 ? -value : value; };
    const double d1 = db - da, d2 = dc - da;
    if (max_of(0.0, max_of(d1, d2)) - min_of(0.0, min_of(d1, d2)) <= discontinuity_px) return false;
    const double bx = static_cast<double>(b.x) - a.x, by = static_cast<double>(b.y) - a.y;
    const double cx = static_cast<double>(c.x) - a.x, cy = static_cast<double>(c.y) - a.y;
    const double area2 = size(bx * cy - cx * by);
    if (area2 > 2 * kSliver_px2) return false;
    return size(d1 * cy - d2 * by) > area2 || size(d2 * bx - d1 * cx) > area2;
}

}  // namespace hexrelief::step
