// Steps 7 and 9: the triangles, and those that are split where their edges cross a silhouette.
#include <algorithm>
#include <map>

#include "oracle_parts.h"

namespace hexrelief::surface::oracle {
namespace {

using Corners = std::array<Vec2f, 3>;

bool has_area(const Vec2f& a, const Vec2f& b, const Vec2f& c) {
    const double area2 =
        (double(b.x) - a.x) * (double(c.y) - a.y) - (double(b.y) - a.y) * (double(c.x) - a.x);
    return area2 > 1e-4f;
}

float distance2(const Vec2f& a, const Vec2f& b) {
    return (a.x - b.x) * (a.x - b.x) + (a.y - b.y) * (a.y - b.y);
}

// Returns the parts of a triangle; on_edge: the new vertex on the edge from corner k to k + 1, -1: none.
std::vector<Triangle> parts_of(const std::vector<Vec2f>& points, const Triangle& t,
                               const std::array<std::int64_t, 3>& on_edge) {
    const auto count = 3 - std::count(on_edge.begin(), on_edge.end(), -1);
    // rotates the corners so that the first one begins the only split edge, or lies between two of them
    int first = 0;
    const auto is_split = [&](int k) { return on_edge[(first + k) % 3] >= 0; };
    if (count == 1)
        while (!is_split(0)) ++first;
    if (count == 2)
        while (is_split(1)) ++first;
    const auto corner = [&](int k) { return t[(first + k) % 3]; };
    const auto middle = [&](int k) { return static_cast<std::uint32_t>(on_edge[(first + k) % 3]); };
    const std::uint32_t a = corner(0), b = corner(1), c = corner(2), ab = middle(0), bc = middle(1),
                        ca = middle(2);
    if (count == 0) return {t};
    if (count == 1) return {{a, ab, c}, {ab, b, c}};
    if (count == 3) return {{a, ab, ca}, {b, bc, ab}, {c, ca, bc}, {ab, bc, ca}};
    // the shorter diagonal divides the remaining quad
    if (distance2(points[ab], points[c]) <= distance2(points[b], points[ca]))
        return {{a, ab, ca}, {ab, b, c}, {ab, c, ca}};
    return {{a, ab, ca}, {ab, b, ca}, {b, c, ca}};
}

// share_at(t, n, a, b): where the edge between triangles t and n (-1: none) is to be split, as a share of the
// way from its vertex a to b, a < b. Not nearer than 0.12 of the edge to its ends. Parts without an area are
// left out; the first of the others takes its triangle's number.
template <typename ShareAt>
void split(PlaneMesh& mesh, const ShareAt& share_at) {
    const std::vector<std::array<int, 3>> neighbours = neighbours_of(mesh.triangles);
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::int64_t> new_points;  // by the ends of their edges
    const int before = static_cast<int>(mesh.triangles.size());
    for (int t = 0; t < before; ++t)
        for (int k = 0; k < 3; ++k) {
            const int n = neighbours[t][k];
            if (n >= 0 && n < t) continue;
            const auto [a, b] = std::minmax(mesh.triangles[t][k], mesh.triangles[t][(k + 1) % 3]);
            const float share = share_at(t, n, a, b);
            if (!(share >= 0.12f && share <= 1 - 0.12f)) continue;
            new_points[{a, b}] = static_cast<std::int64_t>(mesh.points.size());
            mesh.points.push_back(between(mesh.points[a], mesh.points[b], share));
        }
    for (int t = 0; t < before; ++t) {
        std::array<std::int64_t, 3> on_edge;
        for (int k = 0; k < 3; ++k) {
            const auto found =
                new_points.find(std::minmax(mesh.triangles[t][k], mesh.triangles[t][(k + 1) % 3]));
            on_edge[k] = found == new_points.end() ? -1 : found->second;
        }
        std::vector<Triangle> parts = parts_of(mesh.points, mesh.triangles[t], on_edge);
        std::erase_if(parts, [&](const Triangle& p) {
            return !has_area(mesh.points[p[0]], mesh.points[p[1]], mesh.points[p[2]]);
        });
        if (parts.empty()) continue;
        mesh.triangles[t] = parts[0];
        mesh.triangles.insert(mesh.triangles.end(), parts.begin() + 1, parts.end());
    }
}

}  // namespace

PlaneMesh triangles_of(const HexMesh2D& lattice) {
    PlaneMesh mesh{lattice.positions, {}};
    for (int row = 0; row + 1 < lattice.rows; ++row)
        for (int column = 0; column + 1 < lattice.columns; ++column)
            for (const Triangle& t : quad_triangles(lattice.columns, column, row))
                if (has_area(mesh.points[t[0]], mesh.points[t[1]], mesh.points[t[2]]))
                    mesh.triangles.push_back(t);
    return mesh;
}

std::vector<std::array<int, 3>> neighbours_of(const std::vector<Triangle>& triangles) {
    std::map<std::pair<std::uint32_t, std::uint32_t>, int> by_edge;
    for (std::size_t t = 0; t < triangles.size(); ++t)
        for (int k = 0; k < 3; ++k)
            by_edge[{triangles[t][k], triangles[t][(k + 1) % 3]}] = static_cast<int>(t);
    std::vector<std::array<int, 3>> neighbours(triangles.size());
    for (std::size_t t = 0; t < triangles.size(); ++t)
        for (int k = 0; k < 3; ++k) {
            const auto found = by_edge.find({triangles[t][(k + 1) % 3], triangles[t][k]});
            neighbours[t][k] = found == by_edge.end() ? -1 : found->second;
        }
    return neighbours;
}

void split_at_silhouettes(const Surfaces& s, const std::vector<bool>& on_silhouette, PlaneMesh& mesh) {
    const PlaneMesh before = mesh;
    split(mesh, [&](int, int, std::uint32_t a, std::uint32_t b) {
        return edge_crossing(s, before.points[a], on_silhouette[a], before.points[b], on_silhouette[b], true);
    });
}

void split_straddling(const Surfaces& s, const std::vector<bool>& straddling, PlaneMesh& mesh) {
    const PlaneMesh before = mesh;
    split(mesh, [&](int t, int n, std::uint32_t a, std::uint32_t b) {
        if (!straddling[t] && !(n >= 0 && straddling[n])) return -1.0f;
        return crossing_near_middle(s, before.points[a], before.points[b]);
    });
}

}  // namespace hexrelief::surface::oracle
