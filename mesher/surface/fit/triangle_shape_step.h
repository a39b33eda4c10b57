// Vertices that all move at once: which of a triangle's may, so that it does not become thin.
#pragma once

#include <cmath>

#include "mesher/common/host_device.h"
#include "pipeline/data/geometry.h"

namespace hexrelief::step {

inline constexpr double kShapeScale = 3.4641016151377544;

// Twice a triangle's area and the sum of its squared sides. Number: double, or a vector of them.
template <typename Number>
struct SizeOf {
    Number area2, sides2;
};
using TriangleSize = SizeOf<double>;

template <typename Number>
HEXRELIEF_HD SizeOf<Number> size_between(const Number& ax, const Number& ay, const Number& bx,
                                         const Number& by, const Number& cx, const Number& cy) {
    const Number abx = bx - ax, aby = by - ay, acx = cx - ax, acy = cy - ay, bcx = acx - abx, bcy = acy - aby;
    return {abx * acy - aby * acx, abx * abx + aby * aby + acx * acx + acy * acy + bcx * bcx + bcy * bcy};
}

HEXRELIEF_HD TriangleSize triangle_size(const Vec2f& a, const Vec2f& b, const Vec2f& c) {
    return size_between<double>(a.x, a.y, b.x, b.y, c.x, c.y);
}

// Whether its shape, 1 if equilateral, 0 if degenerate, is below `least`.
HEXRELIEF_HD bool is_thin(const TriangleSize& size, double least) {
    return !(kShapeScale * size.area2 >= least * size.sides2 && size.sides2 > 0);
}

HEXRELIEF_HD bool is_thinner(const TriangleSize& size, const TriangleSize& before) {
    return !(size.area2 * before.sides2 >= before.area2 * size.sides2 && size.sides2 > 0);
}

// How far, squared, the corners of a triangle may each be from where they are now without its being thin:
// what free_corners() begins with, solved for the way.
HEXRELIEF_HD float corner_slack2(const Vec2f& a, const Vec2f& b, const Vec2f& c, double least) {
    constexpr double kRounding = 0.999;
    const TriangleSize size = triangle_size(a, b, c);
    const double spare = kShapeScale * size.area2 - least * size.sides2;
    if (!(spare > 0)) return 0;
    const double per_way = std::sqrt(3 * size.sides2) * (kShapeScale + 4 * least),
                 per_way2 = 3 * kShapeScale + 12 * least;
    const double way =
        kRounding * (std::sqrt(per_way * per_way + 4 * per_way2 * spare) - per_way) / (2 * per_way2);
    return static_cast<float>(kRounding * way * way);
}

// Which corners of a triangle may go (bit k: corner k), so that whichever of these then do, for other
// triangles may hold them back, it is no thinner than `least`, or than it was. Those that go farther are
// asked first.
HEXRELIEF_HD unsigned free_corners(const Vec2f from[3], const Vec2f to[3], double least) {
    const auto size_of = [&](unsigned gone) {
        return triangle_size(gone & 1 ? to[0] : from[0], gone & 2 ? to[1] : from[1],
                             gone & 4 ? to[2] : from[2]);
    };
    unsigned moving = 0;
    float sizes[3], farthest = 0;
    for (int k = 0; k < 3; ++k) {
        const float dx = to[k].x - from[k].x, dy = to[k].y - from[k].y;
        sizes[k] = dx * dx + dy * dy;
        farthest = max_of(farthest, sizes[k]);
        moving |= static_cast<unsigned>((dx != 0) | (dy != 0)) << k;
    }
    // as mostly: whatever moves by so little leaves more of the area and less of the sides than it takes
    const TriangleSize before = size_of(0);
    const double off2 = farthest, along = std::sqrt(3 * off2 * before.sides2);
    if (!is_thin({before.area2 - along - 3 * off2, before.sides2 + 4 * along + 12 * off2}, least))
        return moving;
    // bit `gone`: whether the triangle is thin with those corners gone; and thinner than it was
    unsigned thin = 0, bad = 0;
    HEXRELIEF_UNROLL
    for (unsigned gone = 1; gone < 8; ++gone) {
        const TriangleSize size = size_of(gone);
        const bool is_one = is_thin(size, least);
        thin |= static_cast<unsigned>(is_one) << gone;
        bad |= static_cast<unsigned>(is_one & is_thinner(size, before)) << gone;
    }
    if (thin == 0) return moving;
    unsigned allowed = 0;
    for (unsigned left = moving; left != 0;) {
        int next = -1;
        for (int k = 0; k < 3; ++k)
            if ((left >> k & 1) && (next < 0 || sizes[k] > sizes[next])) next = k;
        const unsigned bit = 1u << next;
        left &= ~bit;
        bool holds = true;
        for (unsigned others = allowed;; others = (others - 1) & allowed) {
            holds = holds && !(bad >> (others | bit) & 1u);
            if (others == 0) break;
        }
        if (holds) allowed |= bit;
    }
    return allowed;
}

}  // namespace hexrelief::step
