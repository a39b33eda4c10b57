// Computes a triangle's sums from its pixels' moments, without reading the pixels again.
#pragma once

#include "mesher/common/surface_thresholds_step.h"
#include "mesher/surface/fit/fit_disparities_step.h"
#include "pipeline/base/host_device.h"

namespace hexrelief::step {

// True if the triangle is not too thin for full_sums().
HEXRELIEF_HD bool holds_sums(const PlanePatch& p) {
    const double bcx = p.acx - p.abx, bcy = p.acy - p.aby;
    const double longest =
        max_of(p.abx * p.abx + p.aby * p.aby, max_of(p.acx * p.acx + p.acy * p.acy, bcx * bcx + bcy * bcy));
    return p.area * p.area > kFullLeastShape * (longest * longest);
}

// Returns the sums of add_pixel() over the pixels of the moments, all with weight 1.
HEXRELIEF_HD TriangleSums full_sums(const Moments& m, const PlanePatch& p) {
    // Coordinates are counted from a whole pixel near corner a first, then from the corner.
    const double column = static_cast<double>(static_cast<int>(p.x)),
                 row = static_cast<double>(static_cast<int>(p.y));
    const Moments o = from_pixel(m, column, row);
    const double u = p.x - 0.5 - column, v = p.y - 0.5 - row;
    const double ax = o.x - m.n * u, ay = o.y - m.n * v;
    const double axx = o.xx - u * (o.x + ax), axy = o.xy - u * o.y - v * ax, ayy = o.yy - v * (o.y + ay);
    const double axd = o.xd - u * m.d, ayd = o.yd - v * m.d;
    // A pixel's barycentric coordinates of corners b and c are bx x + by y and cx x + cy y.
    const double bx = p.acy / p.area, by = -p.acx / p.area, cx = -p.aby / p.area, cy = p.abx / p.area;
    const double b = bx * ax + by * ay, c = cx * ax + cy * ay;
    const double bb = bx * bx * axx + 2 * (bx * by) * axy + by * by * ayy,
                 bc = bx * cx * axx + (bx * cy + by * cx) * axy + by * cy * ayy,
                 cc = cx * cx * axx + 2 * (cx * cy) * axy + cy * cy * ayy;
    const double bd = bx * axd + by * ayd, cd = cx * axd + cy * ayd;
    return {{m.n - 2 * (b + c) + (bb + 2 * bc + cc), bb, cc},
            {b - bb - bc, bc, c - bc - cc},
            {m.d - bd - cd, bd, cd}};
}

}  // namespace hexrelief::step
