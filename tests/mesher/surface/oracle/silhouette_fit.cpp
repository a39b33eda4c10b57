// Step 11: silhouette vertices move so that the edges between them fit the crack edges.
#include <algorithm>
#include <cmath>
#include <optional>

#include "oracle_parts.h"

namespace hexrelief::surface::oracle {
namespace {

struct BorderEdge {
    std::uint32_t a, b;
};

// A crack edge as seen from a mesh edge beside it, in floats.
struct Sight {
    float share, residual;  // share of the way along the edge; distance from it in px, to the left
    // facing: component of the direction to the nearer surface along the normal, -1 .. 1
    float weight, facing;
};

// The demands of crack edges on an edge's two vertices: weights, and residuals times weights, px.
struct Demands {
    float nx, ny;  // the edge's normal
    double weights[2], residuals[2];
};

// Returns the edges between a kept triangle and one that is not kept, and those along which the mesh is cut;
// each once, as the lower of its triangles has it. Edges of the image's border are not included.
std::vector<BorderEdge> silhouette_edges(const PlaneMesh& mesh, const std::vector<bool>& kept,
                                         const CutEdges& cut) {
    const std::vector<std::array<int, 3>> neighbours = neighbours_of(mesh.triangles);
    std::vector<BorderEdge> edges;
    for (int t = 0; t < static_cast<int>(mesh.triangles.size()); ++t)
        for (int k = 0; k < 3; ++k) {
            const int n = neighbours[t][k];
            if (n > t && (kept[t] != kept[n] || (kept[t] && cut[t][k])))
                edges.push_back({mesh.triangles[t][k], mesh.triangles[t][(k + 1) % 3]});
        }
    return edges;
}

// Returns the crack edge's midpoint, or 410/1024 px inside the near surface at a step of less than 4 px down
// to the right: the strip beyond it that only the other camera sees is narrow, and an error would hide it.
Vec2f wanted_middle(const Surfaces& s, const CrackEdge& c) {
    const float first = s.first(c), second = s.second(c);
    Vec2f middle = s.middle(c);
    if (!c.down && second > 0 && first > second && first - second < 4) middle.x -= 410 / 1024.0f;
    return middle;
}

// Returns the crack edge as the edge p -> q sees it. Weights fall to 0 at 1.5 px from the edge, and double if
// the edge passes a pixel's centre on the wrong side or by less than 0.05 px. Nothing: the crack edge lies
// beyond the edge's ends or reach.
std::optional<Sight> see(const Surfaces& s, const CrackEdge& c, const Vec2f& p, const Vec2f& q) {
    const float dx = q.x - p.x, dy = q.y - p.y, size2 = dx * dx + dy * dy, size = std::sqrt(size2);
    const float nx = -dy / size, ny = dx / size;
    const Vec2f middle = wanted_middle(s, c);
    const float mx = middle.x - p.x, my = middle.y - p.y;
    const float share = (mx * dx + my * dy) / size2, residual = mx * nx + my * ny;
    if (!(share >= 0 && share <= 1 && std::fabs(residual) <= 1.5f)) return std::nullopt;
    const float towards = s.first(c) > s.second(c) ? -1.0f : 1.0f, away = residual / 1.5f;
    const float facing = towards * (c.down ? ny : nx);
    const float urgency = std::fabs(residual) > 0.5f * std::fabs(facing) - 0.05f ? 2.0f : 1.0f;
    return Sight{share, residual, (1 - away * away) * urgency, facing};
}

// Only crack edges that face as most of them do count: the others belong to another silhouette.
Demands demands_on(const Surfaces& s, const std::vector<CrackEdge>& cracks, const Vec2f& p, const Vec2f& q) {
    Demands demands{0, 0, {0, 0}, {0, 0}};
    const float dx = q.x - p.x, dy = q.y - p.y, size2 = dx * dx + dy * dy;
    if (!(size2 > 0)) return demands;
    demands.nx = -dy / std::sqrt(size2);
    demands.ny = dx / std::sqrt(size2);
    std::vector<Sight> seen;
    for (const CrackEdge& c : cracks)
        if (const std::optional<Sight> sight = see(s, c, p, q)) seen.push_back(*sight);
    double facing = 0;
    for (const Sight& sight : seen) facing += sight.weight * sight.facing;
    for (const Sight& sight : seen) {
        if (!(sight.facing * facing > 0)) continue;
        const double weight = sight.weight;
        const double shares[2] = {weight * (1 - sight.share), weight * sight.share};
        for (int end = 0; end < 2; ++end) {
            demands.weights[end] += shares[end];
            demands.residuals[end] += shares[end] * sight.residual;
        }
    }
    return demands;
}

// Returns the least-squares target of one vertex's edges, drawn towards staying with a weight of 0.3: the
// vertex stays if it would move less than 0.03 px, and moves along the image's border if it lies on it.
Vec2f least_squares_target(const Surfaces& s, const Vec2f& from,
                           const std::vector<std::pair<Demands, int>>& ends) {
    double xx = 0, xy = 0, yy = 0, x = 0, y = 0;
    for (const auto& [demands, end] : ends) {
        const double nx = demands.nx, ny = demands.ny;
        xx += demands.weights[end] * nx * nx;
        xy += demands.weights[end] * nx * ny;
        yy += demands.weights[end] * ny * ny;
        x += demands.residuals[end] * nx;
        y += demands.residuals[end] * ny;
    }
    xx += 0.3;
    yy += 0.3;
    const double determinant = xx * yy - xy * xy;
    double ux = (x * yy - y * xy) / determinant, uy = (y * xx - x * xy) / determinant;
    if (ux * ux + uy * uy < 0.03 * 0.03) return from;
    const float width = static_cast<float>(s.width), height = static_cast<float>(s.height);
    if (from.x <= 0 || from.x >= width) ux = 0;
    if (from.y <= 0 || from.y >= height) uy = 0;
    return {std::clamp(moved(from.x, ux), 0.0f, width), std::clamp(moved(from.y, uy), 0.0f, height)};
}

// Moves all vertices at once, except those that one of their triangles holds.
void move_where_free(const std::vector<Vec2f>& targets, PlaneMesh& mesh) {
    std::vector<bool> held(mesh.points.size(), false);
    for (const Triangle& t : mesh.triangles) {
        const std::array<Vec2f, 3> from{mesh.points[t[0]], mesh.points[t[1]], mesh.points[t[2]]};
        const std::array<Vec2f, 3> to{targets[t[0]], targets[t[1]], targets[t[2]]};
        const std::array<bool, 3> free = free_corners(from, to, 0.1);
        for (int k = 0; k < 3; ++k)
            if (!free[k]) held[t[k]] = true;
    }
    for (std::size_t v = 0; v < held.size(); ++v)
        if (!held[v]) mesh.points[v] = targets[v];
}

}  // namespace

std::array<bool, 3> free_corners(const std::array<Vec2f, 3>& from, const std::array<Vec2f, 3>& to,
                                 double least) {
    struct Size {
        double area2, sides2;  // twice the area; the sum of the squared sides
    };
    const auto size_of = [&](unsigned gone) {
        const auto at = [&](unsigned k) { return gone >> k & 1 ? to[k] : from[k]; };
        const double abx = double(at(1).x) - at(0).x, aby = double(at(1).y) - at(0).y,
                     acx = double(at(2).x) - at(0).x, acy = double(at(2).y) - at(0).y;
        const double bcx = acx - abx, bcy = acy - aby;
        return Size{abx * acy - aby * acx,
                    abx * abx + aby * aby + acx * acx + acy * acy + bcx * bcx + bcy * bcy};
    };
    const Size before = size_of(0);
    const auto is_bad = [&](unsigned gone) {
        const Size after = size_of(gone);
        const bool thin = !(3.4641016151377544 * after.area2 >= least * after.sides2 && after.sides2 > 0),
                   thinner =
                       !(after.area2 * before.sides2 >= before.area2 * after.sides2 && after.sides2 > 0);
        return thin && thinner;
    };
    // those that move farther are asked first, equal ones in their order
    std::array<unsigned, 3> order{0, 1, 2};
    const auto way2 = [&](unsigned k) {
        const float dx = to[k].x - from[k].x, dy = to[k].y - from[k].y;
        return dx * dx + dy * dy;
    };
    std::stable_sort(order.begin(), order.end(), [&](unsigned j, unsigned k) { return way2(j) > way2(k); });
    unsigned allowed = 0;
    for (const unsigned k : order) {
        if (to[k] == from[k]) continue;
        bool may = true;
        for (unsigned others = 0; others < 8; ++others)
            if ((others & ~allowed) == 0 && is_bad(others | 1u << k)) may = false;
        if (may) allowed |= 1u << k;
    }
    std::array<bool, 3> free;
    for (unsigned k = 0; k < 3; ++k) free[k] = to[k] == from[k] || (allowed >> k & 1);
    return free;
}

void fit_silhouettes(const Surfaces& s, const std::vector<bool>& kept, const CutEdges& cut, PlaneMesh& mesh) {
    const std::vector<CrackEdge> cracks = all_discontinuities(s);
    const std::vector<BorderEdge> edges = silhouette_edges(mesh, kept, cut);
    for (int round = 0; round < 5; ++round) {
        std::vector<std::vector<std::pair<Demands, int>>> ends(mesh.points.size());
        for (const BorderEdge& edge : edges) {
            const Demands demands = demands_on(s, cracks, mesh.points[edge.a], mesh.points[edge.b]);
            ends[edge.a].emplace_back(demands, 0);
            ends[edge.b].emplace_back(demands, 1);
        }
        std::vector<Vec2f> targets = mesh.points;
        for (std::size_t v = 0; v < targets.size(); ++v)
            if (!ends[v].empty()) targets[v] = least_squares_target(s, mesh.points[v], ends[v]);
        move_where_free(targets, mesh);
    }
}

}  // namespace hexrelief::surface::oracle
