#include "mesher/align.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "mesher/steps/lattice.h"

namespace hexrelief {
namespace {

constexpr float kLeastShape = 0.3f;  // of a moved triangle, see shape()
constexpr float kOnRim_px = 1.25f;   // a crossing this near to a vertex on the rim is that vertex
constexpr float kOnRimShare = 0.3f;  // the same as a share of the edge

// 1 for an equilateral triangle, 0 for a degenerate one, negative for an inverted one.
float shape(const Vec2f& a, const Vec2f& b, const Vec2f& c) {
    const float abx = b.x - a.x, aby = b.y - a.y, acx = c.x - a.x, acy = c.y - a.y, bcx = c.x - b.x,
                bcy = c.y - b.y;
    const float sum = abx * abx + aby * aby + acx * acx + acy * acy + bcx * bcx + bcy * bcy;
    return sum > 0 ? 3.4641016f * (abx * acy - aby * acx) / sum : 0;
}

float length(const Vec2f& a, const Vec2f& b) {
    return std::sqrt((b.x - a.x) * (b.x - a.x) + (b.y - a.y) * (b.y - a.y));
}

// Where on its ways to its neighbours a vertex meets rims.
struct Crossings {
    std::array<float, 6> shares{-1, -1, -1, -1, -1, -1};  // of the edges; below 0: nowhere
    std::uint8_t stale = 0x3f;                            // bits of edges that are to be looked at
    bool in_vain =
        false;         // the vertex could not move to the nearest; it still cannot while no neighbour moves
    float share = -1;  // the least one
    Vec2f place;       // there
};

class Aligner {
  public:
    Aligner(const PixelSurfaces& surfaces, HexMesh2D& mesh, Team& team)
        : surfaces_(surfaces),
          view_(surfaces.view()),
          mesh_(mesh),
          team_(team),
          on_rim_(mesh.positions.size(), 0),
          crossings_(mesh.positions.size()) {}

    std::vector<std::uint8_t> run() {
        for (const float reach : {0.5f, 0.5f, 0.75f}) {
            team_.for_ranges(mesh_.positions.size(), [&](std::size_t first, std::size_t last) {
                for (std::size_t v = first; v < last; ++v) refresh(static_cast<std::uint32_t>(v));
            });
            std::vector<std::pair<float, std::uint32_t>> order;
            for (std::uint32_t v = 0; v < mesh_.positions.size(); ++v)
                if (crossings_[v].share >= 0 && crossings_[v].share <= reach)
                    order.emplace_back(crossings_[v].share, v);
            std::sort(order.begin(), order.end());
            for (const auto& [share, v] : order) {
                refresh(v);  // a neighbour may have moved
                Crossings& c = crossings_[v];
                if (c.share >= 0 && c.share <= reach && !c.in_vain) c.in_vain = !snap(v);
            }
        }
        return std::move(on_rim_);
    }

  private:
    template <typename Visit>
    void each_neighbour(std::uint32_t v, const Visit& visit) const {
        const int column = static_cast<int>(v % mesh_.columns), row = static_cast<int>(v / mesh_.columns);
        for (int k = 0; k < 6; ++k) {
            const step::Offset o = step::neighbour_offset(row, k);
            const int c = column + o.column, r = row + o.row;
            if (c >= 0 && r >= 0 && c < mesh_.columns && r < mesh_.rows)
                visit(static_cast<std::uint32_t>(mesh_.index(c, r)), k);
        }
    }
    void refresh(std::uint32_t v) {
        Crossings& c = crossings_[v];
        if (c.stale == 0) return;
        const bool any = c.stale != Crossings{}.stale || may_cross_around(v);
        const Vec2f& p = mesh_.positions[v];
        c.share = -1;
        c.in_vain = false;
        each_neighbour(v, [&](std::uint32_t u, int k) {
            const Vec2f& q = mesh_.positions[u];
            if (c.stale >> k & 1)
                c.shares[k] = any && !on_rim_[v] ? open_crossing(surfaces_, p, false, q, on_rim_[u]) : -1;
            const float t = c.shares[k];
            if (t < 0 || (c.share >= 0 && t >= c.share)) return;
            c.share = t;
            c.place = {p.x + t * (q.x - p.x), p.y + t * (q.y - p.y)};
        });
        c.stale = 0;
    }
    // Mostly not: one look for all edges.
    bool may_cross_around(std::uint32_t v) const {
        Vec2f lower = mesh_.positions[v], upper = lower;
        each_neighbour(v, [&](std::uint32_t u, int) {
            const Vec2f& q = mesh_.positions[u];
            lower = {std::min(lower.x, q.x), std::min(lower.y, q.y)};
            upper = {std::max(upper.x, q.x), std::max(upper.y, q.y)};
        });
        return surfaces_.may_cross(lower, upper);
    }
    // The rim's point nearest to v, not farther than the crossing.
    Vec2f nearest_rim(std::uint32_t v, const Vec2f& crossing) const {
        const Vec2f& p = mesh_.positions[v];
        const float reach = length(p, crossing) + 0.5f;
        const int r = static_cast<int>(reach) + 1, x = static_cast<int>(p.x), y = static_cast<int>(p.y);
        float least = reach * reach;
        step::Crack best{-1, -1, 0};
        const int i0 = std::max(0, x - r), i1 = std::min(view_.width - 1, x + r);
        const int j0 = std::max(0, y - r), j1 = std::min(view_.height - 1, y + r);
        for (int j = j0; j <= j1; ++j)
            for (int i = i0; i <= i1; ++i) {
                if (!(view_.flags[view_.index(i, j)] & (step::kJumpRight | step::kJumpDown))) continue;
                for (int down = 0; down < 2; ++down) {
                    const step::Crack c{i, j, down};
                    if (!step::has_crack(view_, c)) continue;
                    const step::Middle middle = step::crack_middle(view_, c);
                    const float dx = middle.x - p.x, dy = middle.y - p.y;
                    const float distance2 = dx * dx + dy * dy;
                    if (distance2 >= least) continue;
                    least = distance2;
                    best = c;
                }
            }
        if (best.x < 0) return crossing;
        const step::RimPoint rim = step::rim_point(view_, best);
        const float along = step::clamp_to((p.y - rim.y) * rim.nx - (p.x - rim.x) * rim.ny, -0.75f, 0.75f);
        return {rim.x - along * rim.ny, rim.y + along * rim.nx};
    }
    bool snap(std::uint32_t v) {
        const Vec2f crossing = crossings_[v].place;
        return try_move(v, nearest_rim(v, crossing)) || try_move(v, crossing);
    }
    bool try_move(std::uint32_t v, Vec2f to) {
        const int column = static_cast<int>(v % mesh_.columns), row = static_cast<int>(v / mesh_.columns);
        const Vec2f from = mesh_.positions[v];
        const float w = static_cast<float>(view_.width), h = static_cast<float>(view_.height);
        const bool side = from.x <= 0 || from.x >= w, end = from.y <= 0 || from.y >= h;
        if (side && end) return false;
        if (side) to.x = from.x;
        if (end) to.y = from.y;
        to = {step::clamp_to(to.x, 0.0f, w), step::clamp_to(to.y, 0.0f, h)};
        mesh_.positions[v] = to;
        const float after = worst_shape(column, row);
        mesh_.positions[v] = from;
        if (!(after >= kLeastShape) && !(after >= worst_shape(column, row))) return false;
        mesh_.positions[v] = to;
        on_rim_[v] = 1;
        crossings_[v].stale = Crossings{}.stale;
        each_neighbour(v, [&](std::uint32_t u, int k) { crossings_[u].stale |= 1 << (k + 3) % 6; });
        return true;
    }
    // Of the triangles around a vertex.
    float worst_shape(int column, int row) const {
        const std::uint32_t v = static_cast<std::uint32_t>(mesh_.index(column, row));
        float worst = 1;
        for (int r = std::max(0, row - 1); r <= std::min(row, mesh_.rows - 2); ++r)
            for (int c = std::max(0, column - 1); c <= std::min(column, mesh_.columns - 2); ++c)
                for (const Triangle& t : quad_triangles(mesh_.columns, c, r)) {
                    if (t[0] != v && t[1] != v && t[2] != v) continue;
                    worst = std::min(
                        worst, shape(mesh_.positions[t[0]], mesh_.positions[t[1]], mesh_.positions[t[2]]));
                }
        return worst;
    }

    const PixelSurfaces& surfaces_;
    step::PixelView view_;
    HexMesh2D& mesh_;
    Team& team_;
    std::vector<std::uint8_t> on_rim_;
    std::vector<Crossings> crossings_;
};

}  // namespace

float open_crossing(const PixelSurfaces& surfaces, const Vec2f& a, bool a_on_rim, const Vec2f& b,
                    bool b_on_rim) {
    if ((a_on_rim && b_on_rim) || !surfaces.may_cross(a, b)) return -1;
    const step::PixelView view = surfaces.view();
    const step::Crossing forth = step::walk(view, a.x, a.y, b.x, b.y);
    if (forth.count == 0) return -1;
    const float size = length(a, b), slack = std::max(kOnRim_px / size, kOnRimShare);
    const auto place = [&](const step::Crack& c) {
        return step::meet(step::rim_point(view, c), a.x, a.y, b.x, b.y);
    };
    if (a_on_rim) {  // the crossing farthest from a counts
        const float t = place(step::walk(view, b.x, b.y, a.x, a.y).first);
        return t > slack ? t : -1;
    }
    const float t = place(forth.first);
    return b_on_rim && t > 1 - slack ? -1 : t;
}

float middle_crossing(const step::PixelView& view, const Vec2f& a, const Vec2f& b) {
    const Vec2f m{(a.x + b.x) / 2, (a.y + b.y) / 2};
    float best = -1;
    for (const Vec2f& end : {a, b}) {
        const step::Crossing crossing = step::walk(view, m.x, m.y, end.x, end.y);
        if (crossing.count == 0) continue;
        const float t = step::meet(step::rim_point(view, crossing.first), a.x, a.y, b.x, b.y);
        if (best < 0 || std::fabs(t - 0.5f) < std::fabs(best - 0.5f)) best = t;
    }
    return best;
}

std::vector<std::uint8_t> align_to_rims(const PixelSurfaces& surfaces, HexMesh2D& mesh, Team& team) {
    return Aligner(surfaces, mesh, team).run();
}

}  // namespace hexrelief
