// The disparity of a mesh vertex, taken robustly from the map around it.
#pragma once

#include <cstddef>

#include "mesher/common/host_device.h"

namespace hexrelief::step {

inline constexpr int kFitRadius_px = 2;  // window of 5 x 5 pixels
inline constexpr float kSteepestSlope =
    1.0f;  // px of disparity a pixel: steeper is not visible to both cameras
inline constexpr float kSlopeSlack_px = 1.0f;  // quantisation of whole-pixel maps

struct MapView {
    int width, height;
    const float* disparity;  // px, +inf = unknown
    float background_px;     // smaller disparities are background
};

HEXRELIEF_HD bool is_known(float d) {
    return d < 3.0e38f && d > -3.0e38f;
}

// The known pixel nearest to (x, y) px gives the surface that the vertex lies on; it and the pixels of the
// window that belong to the same surface (no steeper than kSteepestSlope from it) give a least-squares plane,
// evaluated at the vertex and kept within their range. Returns `unknown` where no pixel of the window is
// known or the nearest one is background.
HEXRELIEF_HD float vertex_disparity(const MapView& map, float x, float y, float unknown) {
    const int cx = clamp_to(static_cast<int>(x), 0, map.width - 1),
              cy = clamp_to(static_cast<int>(y), 0, map.height - 1);
    const int x0 = max_of(0, cx - kFitRadius_px), x1 = min_of(map.width - 1, cx + kFitRadius_px);
    const int y0 = max_of(0, cy - kFitRadius_px), y1 = min_of(map.height - 1, cy + kFitRadius_px);
    float nearest = 3.0e38f, reference = 0;
    int rx = 0, ry = 0;
    for (int v = y0; v <= y1; ++v)
        for (int u = x0; u <= x1; ++u) {
            const float d = map.disparity[static_cast<std::size_t>(v) * map.width + u];
            const float dx = static_cast<float>(u) + 0.5f - x, dy = static_cast<float>(v) + 0.5f - y;
            const float distance = dx * dx + dy * dy;
            if (!is_known(d) || !(distance < nearest)) continue;
            nearest = distance;
            reference = d;
            rx = u;
            ry = v;
        }
    if (!(nearest < 3.0e38f) || !(reference >= map.background_px) || !(reference > 0)) return unknown;

    // normal equations around the reference pixel
    double n = 0, sx = 0, sy = 0, sxx = 0, sxy = 0, syy = 0, sd = 0, sxd = 0, syd = 0;
    float least = reference, most = reference;
    for (int v = y0; v <= y1; ++v)
        for (int u = x0; u <= x1; ++u) {
            const float d = map.disparity[static_cast<std::size_t>(v) * map.width + u];
            if (!is_known(d) || d < map.background_px) continue;
            const int du = u - rx, dv = v - ry;
            const float reach = kSlopeSlack_px + kSteepestSlope * static_cast<float>(max_of(
                                                                      du < 0 ? -du : du, dv < 0 ? -dv : dv));
            const float difference = d - reference;
            if (difference > reach || difference < -reach) continue;
            least = min_of(least, d);
            most = max_of(most, d);
            n += 1;
            sx += du;
            sy += dv;
            sxx += du * du;
            sxy += du * dv;
            syy += dv * dv;
            sd += difference;
            sxd += du * static_cast<double>(difference);
            syd += dv * static_cast<double>(difference);
        }
    const double cxx = sxx - sx * sx / n, cxy = sxy - sx * sy / n, cyy = syy - sy * sy / n;
    const double cxd = sxd - sx * sd / n, cyd = syd - sy * sd / n;
    const double determinant = cxx * cyy - cxy * cxy;
    double gx = 0, gy = 0;
    if (determinant > 0.5) {  // whole numbers over n: nothing between 0 and this
        gx = (cxd * cyy - cyd * cxy) / determinant;
        gy = (cyd * cxx - cxd * cxy) / determinant;
    }
    const double at_x = static_cast<double>(x) - 0.5 - rx - sx / n,
                 at_y = static_cast<double>(y) - 0.5 - ry - sy / n;
    const float fitted = static_cast<float>(static_cast<double>(reference) + sd / n + gx * at_x + gy * at_y);
    return clamp_to(fitted, least, most);
}

}  // namespace hexrelief::step
