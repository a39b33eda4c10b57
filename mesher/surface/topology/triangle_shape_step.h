// Measures how thin a triangle is, finds the corners that may move without making it too thin, and lists the
// corners at each vertex of the cut mesh.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>

#include "mesher/common/team_sort_step.h"
#include "pipeline/base/host_device.h"
#include "pipeline/data/geometry.h"
#include "pipeline/data/hex_mesh.h"

namespace hexrelief::step {

// Scales twice the area over the sum of squared sides to 1 for an equilateral triangle: sqrt(12).
inline constexpr double kShapeScale = 3.4641016151377544;

// Returns 1 for an equilateral triangle, 0 for a degenerate one, a negative value for an inverted one. It
// uses floats, because snapping compares the shapes of many triangles, most of which are far from thin.
HEXRELIEF_HD float shape(const Vec2f& a, const Vec2f& b, const Vec2f& c) {
    const float abx = b.x - a.x, aby = b.y - a.y, acx = c.x - a.x, acy = c.y - a.y, bcx = c.x - b.x,
                bcy = c.y - b.y;
    const float sum = abx * abx + aby * aby + acx * acx + acy * acy + bcx * bcx + bcy * bcy;
    return sum > 0 ? static_cast<float>(kShapeScale) * (abx * acy - aby * acx) / sum : 0;
}

// The shape as two numbers in double precision, which are compared without a division: twice a triangle's
// area, and the sum of its squared sides.
struct TriangleSize {
    double area2, sides2;
};

HEXRELIEF_HD TriangleSize triangle_size(const Vec2f& a, const Vec2f& b, const Vec2f& c) {
    const double abx = double(b.x) - a.x, aby = double(b.y) - a.y, acx = double(c.x) - a.x,
                 acy = double(c.y) - a.y, bcx = acx - abx, bcy = acy - aby;
    return {abx * acy - aby * acx, abx * abx + aby * aby + acx * acx + acy * acy + bcx * bcx + bcy * bcy};
}

// True if the triangle's shape is below `least`.
HEXRELIEF_HD bool is_thin(const TriangleSize& size, double least) {
    return !(kShapeScale * size.area2 >= least * size.sides2 && size.sides2 > 0);
}

// True if the triangle's shape is below what it was before.
HEXRELIEF_HD bool is_thinner(const TriangleSize& size, const TriangleSize& before) {
    return !(size.area2 * before.sides2 >= before.area2 * size.sides2 && size.sides2 > 0);
}

// Returns the square, px2, of a distance that each corner of a triangle may move in any direction
// without making it thin: the bound that free_corners() tries first, solved for the distance. 0 if the
// triangle is thin already.
HEXRELIEF_HD float corner_slack2(const Vec2f& a, const Vec2f& b, const Vec2f& c, double least) {
    constexpr double kRounding = 0.999;
    const TriangleSize size = triangle_size(a, b, c);
    const double spare = kShapeScale * size.area2 - least * size.sides2;
    if (!(spare > 0)) return 0;
    const double per_way = kShapeScale * (1 + least) * std::sqrt(3 * size.sides2),
                 per_way2 = 3 * kShapeScale + 9 * least;
    const double way =
        kRounding * (std::sqrt(per_way * per_way + 4 * per_way2 * spare) - per_way) / (2 * per_way2);
    return static_cast<float>(kRounding * way * way);
}

// Returns the largest set of corners that may move, in any subset, without making the triangle too thin:
// its shape stays at least `least`, or at least what it was. Any subset, because other triangles may
// hold some corners back. The set is built corner by corner, the one that moves farthest first; bit k
// stands for corner k.
HEXRELIEF_HD unsigned free_corners(const Vec2f from[3], const Vec2f to[3], double least) {
    const auto size_of = [&](unsigned gone) {
        return triangle_size(gone & 1 ? to[0] : from[0], gone & 2 ? to[1] : from[1],
                             gone & 4 ? to[2] : from[2]);
    };
    unsigned moving = 0;
    float sizes[3];
    for (int k = 0; k < 3; ++k) {
        const float dx = to[k].x - from[k].x, dy = to[k].y - from[k].y;
        sizes[k] = dx * dx + dy * dy;
        moving |= static_cast<unsigned>((dx != 0) | (dy != 0)) << k;
    }
    if ((moving & (moving - 1)) == 0) {  // one corner moves, or none
        const TriangleSize after = triangle_size(to[0], to[1], to[2]);
        return is_thin(after, least) && is_thinner(after, size_of(0)) ? 0 : moving;
    }
    // Mostly all may move: whichever do, the area shrinks and the squared sides grow by at most this (by the
    // Cauchy-Schwarz inequality; kShapeScale is 2 sqrt(3)).
    const TriangleSize before = size_of(0);
    const double moved2 = double(sizes[0]) + sizes[1] + sizes[2], along = std::sqrt(moved2 * before.sides2);
    if (!is_thin({before.area2 - along - moved2, before.sides2 + kShapeScale * along + 3 * moved2}, least))
        return moving;
    // bit `gone` of thin: the triangle is thin with that set of corners moved; of bad: it is
    // also thinner than before
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

// The cut mesh's triangles.
struct MeshTriangles {
    unsigned point_count, count;
    const Triangle* corners;
    const std::uint32_t* sources;  // in the split lattice
};

// Lists for each vertex its corners as 3 * triangle + corner; there must be room for all.
template <typename Team>
HEXRELIEF_TEAM void sort_corners(Team& team, const MeshTriangles& mesh, const BucketView& corners) {
    sort_into(team, mesh.point_count, corners, [&](const auto& put) {
        team.each(mesh.count, [&](std::size_t t) {
            for (std::uint32_t k = 0; k < 3; ++k)
                put(mesh.corners[t][k], 3 * static_cast<std::uint32_t>(t) + k);
        });
    });
}

}  // namespace hexrelief::step
