// Rims at high depth jumps that end inside of their own surfaces: which vertices move, and where.
#pragma once

#include <cmath>

#include "mesher/steps/host_device.h"
#include "mesher/steps/rim.h"
#include "pipeline/data/geometry.h"

namespace hexrelief::step {

// Lower steps stay closed: what shows through the gap would be more wrong than the step itself.
inline constexpr float kInsetLeastStep_px = 2.6f;
inline constexpr int kInsetReach_px = 1;          // of a vertex for the pixels that tell its step
inline constexpr double kInsetLeastShape = 0.05;  // of a triangle at a moved vertex

enum class RimStep { none, low, high, high_to_background };

// The lowest of the steps at the pixel sides next to a point, those down to unknown pixels left out. map: the
// disparities, px, +inf = unknown.
HEXRELIEF_HD RimStep rim_step_at(const PixelView& view, const float* map, const Vec2f& p) {
    const auto known = [](float d) { return d > 0 && d <= 3.402823466e+38f; };
    const int x = static_cast<int>(p.x), y = static_cast<int>(p.y);
    RimStep found = RimStep::none;
    for (int v = y - kInsetReach_px; v <= y + kInsetReach_px; ++v)
        for (int u = x - kInsetReach_px; u <= x + kInsetReach_px; ++u)
            for (int down = 0; down < 2; ++down) {
                if (!has_crack(view, {u, v, down})) continue;
                const std::size_t i = view.index(u, v), j = down ? i + view.width : i + 1;
                const bool inner = view.disparity[i] > 0 && view.disparity[j] > 0;
                const float a = inner ? view.disparity[i] : map[i], b = inner ? view.disparity[j] : map[j];
                if (!known(a) || !known(b)) continue;
                if (std::fabs(a - b) < kInsetLeastStep_px) return RimStep::low;
                if (found != RimStep::high_to_background)
                    found = inner ? RimStep::high : RimStep::high_to_background;
            }
    return found;
}

// doubled: whether the vertex has copies on other surfaces.
HEXRELIEF_HD bool is_inset(RimStep step, bool doubled) {
    return step == RimStep::high_to_background || (step == RimStep::high && doubled);
}

struct Inwards {
    double x = 0, y = 0;
};

// Adds what a triangle says of the way inwards at its corner: an inner edge adds nothing, because its two
// triangles run through it both ways.
HEXRELIEF_HD void add_inwards(Inwards& sum, const Vec2f corners[3], int corner) {
    for (int k = 0; k < 3; ++k) {
        const int next = (k + 1) % 3;
        if (k != corner && next != corner) continue;
        sum.x += double(corners[k].y) - corners[next].y;
        sum.y += double(corners[next].x) - corners[k].x;
    }
}

// Along the image's border only for vertices on it, whose own edges count as rims here.
HEXRELIEF_HD Vec2f inset_point(const Vec2f& p, Inwards to, double by_px, float width, float height) {
    if (p.x <= 0 || p.x >= width) to.x = 0;
    if (p.y <= 0 || p.y >= height) to.y = 0;
    const double size = std::sqrt(to.x * to.x + to.y * to.y);
    if (!(size > 1e-6)) return p;
    return {static_cast<float>(p.x + by_px * to.x / size), static_cast<float>(p.y + by_px * to.y / size)};
}

}  // namespace hexrelief::step
