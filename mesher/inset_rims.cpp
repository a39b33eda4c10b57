#include <algorithm>
#include <cmath>

#include "mesher/sheet_parts.h"

namespace hexrelief {
namespace {

// Lower steps stay closed: what shows through the gap would be more wrong than the step itself.
constexpr float kLeastStep_px = 3;
constexpr int kReach_px = 1;          // of a vertex for the pixels that tell its step
constexpr double kLeastShape = 0.05;  // of a triangle at a moved vertex

struct Sum {
    double x = 0, y = 0;
};

double shape(const Vec2f& a, const Vec2f& b, const Vec2f& c) {
    const double abx = double(b.x) - a.x, aby = double(b.y) - a.y, acx = double(c.x) - a.x,
                 acy = double(c.y) - a.y, bcx = acx - abx, bcy = acy - aby;
    const double sum = abx * abx + aby * aby + acx * acx + acy * acy + bcx * bcx + bcy * bcy;
    return sum > 0 ? 3.4641016151377544 * (abx * acy - aby * acx) / sum : 0;
}

enum class Step { none, low, high, high_to_background };

// The lowest of the steps at the pixel sides next to a point, those down to unknown pixels left out.
Step step_at(const step::PixelView& view, const DisparityMap& map, const Vec2f& p) {
    const int x = static_cast<int>(p.x), y = static_cast<int>(p.y);
    Step found = Step::none;
    for (int v = y - kReach_px; v <= y + kReach_px; ++v)
        for (int u = x - kReach_px; u <= x + kReach_px; ++u)
            for (int down = 0; down < 2; ++down) {
                if (!step::has_crack(view, {u, v, down})) continue;
                const std::size_t i = view.index(u, v), j = down ? i + view.width : i + 1;
                const bool inner = view.disparity[i] > 0 && view.disparity[j] > 0;
                const float a = inner ? view.disparity[i] : map.values[i],
                            b = inner ? view.disparity[j] : map.values[j];
                if (!DisparityMap::known(a) || !DisparityMap::known(b) || !(a > 0) || !(b > 0)) continue;
                if (std::fabs(a - b) < kLeastStep_px) return Step::low;
                if (found != Step::high_to_background) found = inner ? Step::high : Step::high_to_background;
            }
    return found;
}

}  // namespace

void inset_rims(const PixelSurfaces& surfaces, const DisparityMap& map, double by_px,
                const std::vector<std::uint32_t>& olds, const std::vector<Triangle>& triangles,
                std::vector<Vec2f>& points) {
    const step::PixelView view = surfaces.view();
    std::vector<std::uint8_t> moves(points.size(), 0);
    for (std::size_t v = 0; v < points.size(); ++v) {
        const bool doubled =
            (v > 0 && olds[v - 1] == olds[v]) || (v + 1 < olds.size() && olds[v + 1] == olds[v]);
        const Step step = step_at(view, map, points[v]);
        moves[v] = step == Step::high_to_background || (step == Step::high && doubled);
    }
    // The way inwards: an inner edge adds nothing, because its two triangles run through it both ways.
    std::vector<Sum> inwards(points.size());
    for (const Triangle& t : triangles)
        for (int k = 0; k < 3; ++k) {
            const std::uint32_t a = t[k], b = t[(k + 1) % 3];
            const double x = double(points[a].y) - points[b].y, y = double(points[b].x) - points[a].x;
            for (const std::uint32_t v : {a, b}) inwards[v].x += x, inwards[v].y += y;
        }
    std::vector<std::uint32_t> starts(points.size() + 1, 0), items(3 * triangles.size());
    for (const Triangle& t : triangles)
        for (const std::uint32_t v : t) ++starts[v + 1];
    for (std::size_t v = 0; v < points.size(); ++v) starts[v + 1] += starts[v];
    std::vector<std::uint32_t> next(starts.begin(), starts.end() - 1);
    for (std::uint32_t t = 0; t < triangles.size(); ++t)
        for (const std::uint32_t v : triangles[t]) items[next[v]++] = t;
    const float w = static_cast<float>(view.width), h = static_cast<float>(view.height);
    for (std::size_t v = 0; v < points.size(); ++v) {
        Sum to = inwards[v];
        Vec2f& p = points[v];
        // along the image's border only, whose own edges count as rims here
        if (p.x <= 0 || p.x >= w) to.x = 0;
        if (p.y <= 0 || p.y >= h) to.y = 0;
        const double size = std::sqrt(to.x * to.x + to.y * to.y);
        if (!moves[v] || !(size > 1e-6)) continue;
        const Vec2f from = p;
        p = {static_cast<float>(p.x + by_px * to.x / size), static_cast<float>(p.y + by_px * to.y / size)};
        for (std::uint32_t i = starts[v]; i < starts[v + 1]; ++i) {
            const Triangle& t = triangles[items[i]];
            if (shape(points[t[0]], points[t[1]], points[t[2]]) >= kLeastShape) continue;
            p = from;
            break;
        }
    }
}

}  // namespace hexrelief
