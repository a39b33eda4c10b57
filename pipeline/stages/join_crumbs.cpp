#include "pipeline/stages/join_crumbs.h"

#include <algorithm>
#include <compare>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "pipeline/data/union_find.h"

namespace hexrelief::stages {
namespace {

constexpr int kCrumb = 30;         // triangles: smaller components are crumbs
constexpr double kMost_px2 = 0.5;  // a pixel of a cell

// A corner of a crumb, and that of a larger component at the same place, on an edge that both have.
struct Seam {
    std::uint32_t crumb, larger;    // components
    std::uint32_t corner, becomes;  // vertices
    auto operator<=>(const Seam&) const = default;
};

// An edge of a crumb, from one place to another.
struct Edge {
    std::uint32_t from, to;  // places
    std::uint32_t a, b;      // vertices there
    auto operator<=>(const Edge&) const = default;
};

// Returns the first vertex at the place of each: a vertex's copies are adjacent to it.
std::vector<std::uint32_t> places_of(const std::vector<Vec2f>& points) {
    std::vector<std::uint32_t> places(points.size());
    for (std::uint32_t i = 0; i < places.size(); ++i) {
        const bool is_copy = i > 0 && points[i].x == points[i - 1].x && points[i].y == points[i - 1].y;
        places[i] = is_copy ? places[i - 1] : i;
    }
    return places;
}

struct Components {
    std::vector<std::uint32_t> of_vertices;  // a component is named by its first vertex
    std::vector<int> triangles;

    Components(const DisparityMesh& mesh, const std::vector<std::uint32_t>& held)
        : of_vertices(mesh.points.size()), triangles(mesh.points.size()) {
        UnionFind sets(mesh.points.size());
        for (const Triangle& t : mesh.triangles) sets.join(t[0], t[1]), sets.join(t[0], t[2]);
        for (std::uint32_t i = 0; i < of_vertices.size(); ++i) of_vertices[i] = sets.find(i);
        for (const Triangle& t : mesh.triangles) ++triangles[of_vertices[t[0]]];
        for (const std::uint32_t v : held) triangles[of_vertices[v]] = kCrumb;
    }
    bool is_crumb(std::uint32_t vertex) const { return triangles[of_vertices[vertex]] < kCrumb; }
};

// Returns the corners of crumbs where these touch larger components, ordered by both.
std::vector<Seam> find_seams(const DisparityMesh& mesh, const std::vector<std::uint32_t>& places,
                             const Components& components) {
    std::vector<Edge> edges;
    std::vector<std::uint8_t> is_beside(places.size());
    const auto each_edge = [&](bool of_crumbs, const auto& visit) {
        for (const Triangle& t : mesh.triangles)
            if (components.is_crumb(t[0]) == of_crumbs)
                for (std::size_t k = 0; k < 3; ++k) visit(t[k], t[(k + 1) % 3]);
    };
    each_edge(true, [&](std::uint32_t a, std::uint32_t b) {
        is_beside[places[a]] = 1;
        edges.push_back({places[a], places[b], a, b});
    });
    std::sort(edges.begin(), edges.end());
    std::vector<Seam> seams;
    const auto& of = components.of_vertices;
    each_edge(false, [&](std::uint32_t b, std::uint32_t a) {
        if (!is_beside[places[a]] || !is_beside[places[b]]) return;
        for (auto e = std::lower_bound(edges.begin(), edges.end(), Edge{places[a], places[b], 0, 0});
             e != edges.end() && e->from == places[a] && e->to == places[b]; ++e) {
            seams.push_back({of[e->a], of[a], e->a, a});
            seams.push_back({of[e->b], of[b], e->b, b});
        }
    });
    std::sort(seams.begin(), seams.end());
    return seams;
}

double area_of(const DisparityMesh& mesh, const Triangle& t) {
    const Vec2f &p = mesh.points[t[0]], &q = mesh.points[t[1]], &r = mesh.points[t[2]];
    return ((double(q.x) - p.x) * (double(r.y) - p.y) - (double(q.y) - p.y) * (double(r.x) - p.x)) / 2;
}

// Returns the integral over a triangle of the square of what its corners change by.
double cost_of(const DisparityMesh& mesh, const Triangle& t, const double (&by)[3]) {
    return area_of(mesh, t) / 6 *
           (by[0] * (by[0] + by[1]) + by[1] * (by[1] + by[2]) + by[2] * (by[2] + by[0]));
}

// Joins crumbs to larger components; those beside the ones that were joined may be next. Returns whether any
// was.
bool join_once(DisparityMesh& mesh, const std::vector<std::uint32_t>& places, double most_px2,
               double least_px, const std::vector<std::uint32_t>& held) {
    const Components components(mesh, held);
    const std::vector<Seam> seams = find_seams(mesh, places, components);
    if (seams.empty()) return false;
    std::vector<std::vector<Triangle>> crumbs(mesh.points.size());
    for (const Triangle& t : mesh.triangles)
        if (components.is_crumb(t[0])) crumbs[components.of_vertices[t[0]]].push_back(t);
    std::vector<std::uint32_t> becomes(mesh.points.size());
    for (std::uint32_t i = 0; i < becomes.size(); ++i) becomes[i] = i;
    bool any = false;
    for (auto first = seams.begin(); first != seams.end();) {
        const std::uint32_t crumb = first->crumb;
        auto best = seams.end(), best_end = seams.end();
        double area = 0;
        for (const Triangle& t : crumbs[crumb]) area += area_of(mesh, t);
        const bool is_tiny = area < least_px;
        double least = is_tiny ? std::numeric_limits<double>::infinity() : most_px2, best_level = 0;
        while (first != seams.end() && first->crumb == crumb) {
            const auto end = std::find_if(first, seams.end(), [&](const Seam& s) {
                return s.crumb != crumb || s.larger != first->larger;
            });
            double cost = 0, level = 0;
            for (auto s = first; s != end; ++s) level += mesh.disparities[s->becomes];
            level /= static_cast<double>(end - first);
            for (const Triangle& t : crumbs[crumb]) {
                double by[3] = {};
                for (std::size_t k = 0; k < 3; ++k) {
                    const auto seam =
                        std::find_if(first, end, [&](const Seam& s) { return s.corner == t[k]; });
                    const double own = mesh.disparities[t[k]];
                    by[k] = (seam != end ? mesh.disparities[seam->becomes] : is_tiny ? level : own) - own;
                }
                cost += cost_of(mesh, t, by);
            }
            if (cost <= least) least = cost, best = first, best_end = end, best_level = level;
            first = end;
        }
        if (best == seams.end()) continue;
        if (is_tiny)  // flat: no needle reaches to where it was
            for (const Triangle& t : crumbs[crumb])
                for (const std::uint32_t corner : t)
                    mesh.disparities[corner] = static_cast<float>(best_level);
        for (auto s = best_end; s != best;) --s, becomes[s->corner] = s->becomes;
        any = true;
    }
    if (any)
        for (Triangle& t : mesh.triangles)
            for (std::uint32_t& corner : t) corner = becomes[corner];
    return any;
}

}  // namespace

void join_crumbs(DisparityMesh& mesh, double cell_px, double least_px,
                 const std::vector<std::uint32_t>& held) {
    const std::vector<std::uint32_t> places = places_of(mesh.points);
    while (join_once(mesh, places, kMost_px2 * cell_px, least_px, held)) mesh.has_one_fan_per_vertex = false;
}

}  // namespace hexrelief::stages
