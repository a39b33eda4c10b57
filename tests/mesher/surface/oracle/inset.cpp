// Step 14: silhouettes at high steps are inset into their own surfaces.
#include <algorithm>
#include <cmath>
#include <limits>

#include "oracle_parts.h"

namespace hexrelief::surface::oracle {
namespace {

constexpr float kHighStep_px = 2.3f;

// True if the steps at the crack edges of the nine pixels around p are all high, and there is one; those to
// unknown pixels do not count. A step down to the background has the height in the map itself.
bool is_at_high_steps(const Surfaces& s, const DisparityMap& map, const Vec2f& p) {
    const auto is_known = [](float d) { return d > 0 && d <= std::numeric_limits<float>::max(); };
    bool high = false;
    for (int y = static_cast<int>(p.y) - 1; y <= static_cast<int>(p.y) + 1; ++y)
        for (int x = static_cast<int>(p.x) - 1; x <= static_cast<int>(p.x) + 1; ++x)
            for (const bool down : {false, true}) {
                const CrackEdge c{x, y, down};
                if (!s.has(c)) continue;
                const bool inner = s.first(c) > 0 && s.second(c) > 0;
                const float a = inner ? s.first(c) : map.at(x, y), b = inner  ? s.second(c)
                                                                       : down ? map.at(x, y + 1)
                                                                              : map.at(x + 1, y);
                if (!is_known(a) || !is_known(b)) continue;
                if (std::fabs(a - b) < kHighStep_px) return false;
                high = true;
            }
    return high;
}

bool is_at_high_step(const Surfaces& s, int x, int y) {
    for (const CrackEdge& c : {CrackEdge{x, y, false}, CrackEdge{x, y, true}, CrackEdge{x - 1, y, false},
                               CrackEdge{x, y - 1, true}}) {
        if (!s.has(c)) continue;
        const float a = s.first(c), b = s.second(c);
        if (!(a > 0) || !(b > 0) || !(std::fabs(a - b) < kHighStep_px)) return true;
    }
    return false;
}

// True if moving the ends of the edge a -> b, its triangle on the left, to new_a and new_b would uncover the
// centre of a pixel that is not next to a high step. Centres are tested along the columns that the edge
// spans, or along the rows if it is steep.
bool uncovers(const Surfaces& s, const Vec2f& a, const Vec2f& b, const Vec2f& new_a, const Vec2f& new_b) {
    if (new_a == a && new_b == b) return false;
    const bool lies = std::fabs(b.x - a.x) >= std::fabs(b.y - a.y);
    const auto along = [&](const Vec2f& p) { return lies ? p.x : p.y; };
    const auto across = [&](const Vec2f& p) { return lies ? p.y : p.x; };
    const float way = along(b) - along(a), new_way = along(new_b) - along(new_a);
    if (!(std::fabs(new_way) > 0.1f * std::fabs(way))) return true;
    const float slope = (across(b) - across(a)) / way, new_slope = (across(new_b) - across(new_a)) / new_way;
    const bool left_is_beyond = lies == (way > 0);
    const int end = lies ? s.width : s.height, end_across = lies ? s.height : s.width;
    const float low = std::min(along(a), along(b)), high = std::max(along(a), along(b));
    for (int u = 0; u < end; ++u) {
        const float centre = static_cast<float>(u) + 0.5f;
        if (centre > high || u < static_cast<int>(low + 0.5f)) continue;
        const float edge = across(a) + (centre - along(a)) * slope;
        const float new_edge = std::clamp(across(new_a) + (centre - along(new_a)) * new_slope, 0.0f,
                                          static_cast<float>(end_across));
        const float first = left_is_beyond ? edge : new_edge, last = left_is_beyond ? new_edge : edge;
        for (int v = 0; v < end_across; ++v) {
            if (v < static_cast<int>(std::max(first, 0.0f) + 0.5f) || static_cast<float>(v) + 0.5f > last)
                continue;
            if (!is_at_high_step(s, lies ? u : v, lies ? v : u)) return true;
        }
    }
    return false;
}

std::array<Vec2f, 3> corners_of(const std::vector<Vec2f>& points, const Triangle& t) {
    return {points[t[0]], points[t[1]], points[t[2]]};
}

// Returns the vertex moved inwards, along the sum of the normals of the border edges at it, each as long as
// its edge; inner edges cancel out, because their two triangles run through them in opposite directions.
Vec2f moved_inwards(const Surfaces& s, const CutMesh& mesh, std::uint32_t v, double by_px) {
    double x = 0, y = 0;
    for (const Triangle& t : mesh.triangles)
        for (int k = 0; k < 3; ++k) {
            const std::uint32_t a = t[k], b = t[(k + 1) % 3];
            if (a != v && b != v) continue;
            x += double(mesh.points[a].y) - mesh.points[b].y;
            y += double(mesh.points[b].x) - mesh.points[a].x;
        }
    const Vec2f& p = mesh.points[v];
    if (p.x <= 0 || p.x >= static_cast<float>(s.width)) x = 0;
    if (p.y <= 0 || p.y >= static_cast<float>(s.height)) y = 0;
    const double size = std::sqrt(x * x + y * y);
    if (!(size > 1e-6)) return p;
    return {moved(p.x, by_px * x / size), moved(p.y, by_px * y / size)};
}

// Returns, for the triangles of a cut mesh, the edges without a kept triangle on the other side or along
// which the mesh is cut.
CutEdges border_edges(const PlaneMesh& uncut, const std::vector<bool>& kept, const CutEdges& cut,
                      const CutMesh& mesh) {
    const std::vector<std::array<int, 3>> neighbours = neighbours_of(uncut.triangles);
    CutEdges border;
    for (const std::uint32_t t : mesh.source_triangles) {
        border.push_back({});
        for (int k = 0; k < 3; ++k)
            border.back()[k] = neighbours[t][k] < 0 || !kept[neighbours[t][k]] || cut[t][k];
    }
    return border;
}

}  // namespace

void inset_silhouettes(const Surfaces& s, const DisparityMap& map, double by_px, const PlaneMesh& uncut,
                       const std::vector<bool>& kept, const CutEdges& cut, CutMesh& mesh) {
    const CutEdges border = border_edges(uncut, kept, cut, mesh);
    std::vector<Vec2f> targets = mesh.points;
    for (std::uint32_t v = 0; v < targets.size(); ++v)
        if (is_at_high_steps(s, map, mesh.points[v])) targets[v] = moved_inwards(s, mesh, v, by_px);
    std::vector<bool> held(mesh.points.size(), false);
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
        const std::array<Vec2f, 3> from = corners_of(mesh.points, mesh.triangles[t]),
                                   to = corners_of(targets, mesh.triangles[t]);
        const std::array<bool, 3> free = free_corners(from, to, 0.05);
        for (int k = 0; k < 3; ++k) {
            const int next = (k + 1) % 3;
            if (!free[k]) held[mesh.triangles[t][k]] = true;
            if (border[t][k] && uncovers(s, from[k], from[next], to[k], to[next]))
                held[mesh.triangles[t][k]] = held[mesh.triangles[t][next]] = true;
        }
    }
    for (std::size_t v = 0; v < held.size(); ++v)
        if (!held[v]) mesh.points[v] = targets[v];
}

}  // namespace hexrelief::surface::oracle
