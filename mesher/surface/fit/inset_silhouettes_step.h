// Insets silhouettes at high depth discontinuities into their own surfaces: which vertices move and to where,
// and their moves, by a team of threads.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>

#include "mesher/common/surface_thresholds_step.h"
#include "mesher/surface/pixels/crack_edges_step.h"
#include "mesher/surface/topology/cut_vertices_step.h"
#include "mesher/surface/topology/triangle_shape_step.h"
#include "pipeline/base/host_device.h"
#include "pipeline/data/geometry.h"

namespace hexrelief::step {

// True if the steps at the crack edges near a point are all high, not counting those down to unknown pixels,
// and there is at least one. map: the disparities, px, +inf = unknown.
HEXRELIEF_HD bool is_at_high_steps(const PixelView& view, const float* map, const Vec2f& p) {
    const auto known = [](float d) { return d > 0 && d <= 3.402823466e+38f; };
    const int x = static_cast<int>(p.x), y = static_cast<int>(p.y);
    bool found = false;
    for (int v = y - kInsetReach_px; v <= y + kInsetReach_px; ++v)
        for (int u = x - kInsetReach_px; u <= x + kInsetReach_px; ++u)
            for (int down = 0; down < 2; ++down) {
                if (!has_crack(view, {u, v, down})) continue;
                const std::size_t i = view.index(u, v), j = down ? i + view.width : i + 1;
                const bool inner = view.disparity[i] > 0 && view.disparity[j] > 0;
                const float a = inner ? view.disparity[i] : map[i], b = inner ? view.disparity[j] : map[j];
                if (!known(a) || !known(b)) continue;
                if (std::fabs(a - b) < kLowStep_px) return false;
                found = true;
            }
    return found;
}

// True if one of the pixel's own sides is a step that silhouettes are inset from.
HEXRELIEF_HD bool is_at_high_step(const PixelView& view, int x, int y) {
    const auto is_high = [&](const Crack& c) {
        if (!has_crack(view, c)) return false;
        const std::size_t i = view.index(c.x, c.y), j = c.down ? i + view.width : i + 1;
        const float a = view.disparity[i], b = view.disparity[j];
        return !(a > 0) || !(b > 0) || !(std::fabs(a - b) < kLowStep_px);
    };
    return is_high({x, y, 0}) || is_high({x, y, 1}) || is_high({x - 1, y, 0}) || is_high({x, y - 1, 1});
}

// True if moving a silhouette edge a -> b, its triangle on the left, to its targets would uncover a pixel
// centre that is not next to a high step: that would be a hole in what the map shows plainly.
HEXRELIEF_HD bool uncovers_surface(const PixelView& view, const Vec2f& a, const Vec2f& b, const Vec2f& to_a,
                                   const Vec2f& to_b) {
    if (to_a == a && to_b == b) return false;
    const bool lies = std::fabs(b.x - a.x) >= std::fabs(b.y - a.y);
    const auto along = [&](const Vec2f& p) { return lies ? p.x : p.y; };
    const auto across = [&](const Vec2f& p) { return lies ? p.y : p.x; };
    const float way = along(b) - along(a), new_way = along(to_b) - along(to_a);
    if (!(std::fabs(new_way) > kInsetLeastLength * std::fabs(way))) return true;
    const float slope = (across(b) - across(a)) / way, new_slope = (across(to_b) - across(to_a)) / new_way;
    const float last = max_of(along(a), along(b));
    const int end = lies ? view.width : view.height, end_across = lies ? view.height : view.width;
    const int base = floor_of(across(a));  // positions across are counted from there
    const float lowest = static_cast<float>(-base), highest = static_cast<float>(end_across - base);
    const float from = across(a) - static_cast<float>(base), to = across(to_a) - static_cast<float>(base);
    const bool left_is_beyond = lies == (way > 0);
    for (int u = static_cast<int>(min_of(along(a), along(b)) + 0.5f); u < end; ++u) {
        const float centre = static_cast<float>(u) + 0.5f;
        if (centre > last) break;
        const float old_edge = from + (centre - along(a)) * slope,
                    new_edge = clamp_to(to + (centre - along(to_a)) * new_slope, lowest, highest);
        const float first = left_is_beyond ? old_edge : new_edge,
                    beyond = left_is_beyond ? new_edge : old_edge;
        for (int v = base + floor_of(max_of(first, lowest) + 0.5f); v < end_across; ++v) {
            if (static_cast<float>(v - base) + 0.5f > beyond) break;
            if (!is_at_high_step(view, lies ? u : v, lies ? v : u)) return true;
        }
    }
    return false;
}

// True if the same holds for a silhouette edge at a triangle's corner; `lattice` is that corner in the
// split lattice of `fans`.
template <typename Fans>
HEXRELIEF_HD bool uncovers_surface(const PixelView& view, const Fans& fans, const Corner& lattice,
                                   const Vec2f from[3], const Vec2f to[3]) {
    for (int next = 1; next >= 0; --next) {
        Corner beyond = lattice;
        if (next_in_fan(fans, next != 0, beyond)) continue;
        const unsigned k = next ? lattice.k : (lattice.k + 2) % 3, end = (k + 1) % 3;
        if (uncovers_surface(view, from[k], from[end], to[k], to[end])) return true;
    }
    return false;
}

struct Inwards {
    double x = 0, y = 0;
};

// Adds a triangle's contribution to the direction inwards at one of its corners. Inner edges cancel out,
// because their two triangles run through them in opposite directions.
HEXRELIEF_HD void add_inwards(Inwards& sum, const Vec2f corners[3], int corner) {
    for (int k = 0; k < 3; ++k) {
        const int next = (k + 1) % 3;
        if (k != corner && next != corner) continue;
        sum.x += double(corners[k].y) - corners[next].y;
        sum.y += double(corners[next].x) - corners[k].x;
    }
}

// Returns p moved by by_px in the direction `to`. Vertices on the image's border move along it, because their
// own border edges count as silhouettes here.
HEXRELIEF_HD Vec2f inset_point(const Vec2f& p, Inwards to, double by_px, float width, float height) {
    if (p.x <= 0 || p.x >= width) to.x = 0;
    if (p.y <= 0 || p.y >= height) to.y = 0;
    const double size = std::sqrt(to.x * to.x + to.y * to.y);
    if (!(size > 1e-6)) return p;
    return {moved_by(p.x, static_cast<float>(by_px * to.x / size)),
            moved_by(p.y, static_cast<float>(by_px * to.y / size))};
}

struct InsetArrays {
    BucketView corners;   // per vertex: its corners as 3 * triangle + corner
    Vec2f* targets;       // per vertex
    std::uint8_t* moves;  // per vertex: true if it moves to its target
};

// The cut mesh's vertices move apart. map: the disparities, px, +inf = unknown. Fans: FanView of the split
// lattice. All threads of the team call.
template <typename Team, typename Fans>
HEXRELIEF_TEAM void inset_silhouettes(Team& team, const PixelView& view, const float* map, double by_px,
                                      const Fans& fans, const MeshTriangles& mesh, Vec2f* points,
                                      const InsetArrays& a) {
    const float width = static_cast<float>(view.width), height = static_cast<float>(view.height);
    sort_corners(team, mesh, a.corners);
    team.each(mesh.point_count, [&](std::size_t v) {
        const Vec2f p = points[v];
        a.targets[v] = p;
        if (!is_at_high_steps(view, map, p)) return;
        Inwards inwards;
        for (const std::uint32_t* c = a.corners.begin(v); c < a.corners.end(v); ++c) {
            const Triangle& t = mesh.corners[*c / 3];
            const Vec2f at[3] = {points[t[0]], points[t[1]], points[t[2]]};
            add_inwards(inwards, at, static_cast<int>(*c % 3));
        }
        a.targets[v] = inset_point(p, inwards, by_px, width, height);
    });
    team.each(mesh.point_count, [&](std::size_t v) {
        bool moves = !(a.targets[v] == points[v]);
        for (const std::uint32_t* c = a.corners.begin(v); moves && c < a.corners.end(v); ++c) {
            const Triangle& t = mesh.corners[*c / 3];
            const Corner own{mesh.sources[*c / 3], *c % 3};
            const Vec2f from[3] = {points[t[0]], points[t[1]], points[t[2]]},
                        to[3] = {a.targets[t[0]], a.targets[t[1]], a.targets[t[2]]};
            moves = (free_corners(from, to, kInsetLeastShape) >> own.k & 1) != 0 &&
                    !uncovers_surface(view, fans, own, from, to);
        }
        a.moves[v] = moves;
    });
    team.each(mesh.point_count, [&](std::size_t v) {
        if (a.moves[v]) points[v] = a.targets[v];
    });
}

}  // namespace hexrelief::step
