// Steps 10, 12 and 13: the edges along which the mesh is cut, and the vertices that are split there.
#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

#include "oracle_parts.h"

namespace hexrelief::surface::oracle {
namespace {

struct Votes {
    int cut = 0, joined = 0;
};
using EdgeVotes = std::map<std::pair<int, int>, Votes>;  // by an edge's triangles, the lower first

// Adds the vote of two neighbouring pixels in two triangles, if both are in their triangles' labels: whether
// a discontinuity lies between them.
void add_vote(const Surfaces& s, const Labels& labels, const CrackEdge& c, EdgeVotes& votes) {
    const std::size_t i = s.index(c.x, c.y), j = c.down ? s.index(c.x, c.y + 1) : s.index(c.x + 1, c.y);
    const int a = labels.triangle[i], b = labels.triangle[j];
    if (a < 0 || b < 0 || a == b) return;
    if (!labels.in_label[i] || !labels.in_label[j]) return;
    Votes& own = votes[std::minmax(a, b)];
    ++(s.has(c) ? own.cut : own.joined);
}

// True if the disparities of two triangles' anchors differ and a discontinuity lies between the anchors.
bool anchors_differ(const Surfaces& s, const Labels& labels, int t, int n) {
    const std::size_t i = labels.anchor[t], j = labels.anchor[n];
    const float a = s.disparity[i], b = s.disparity[j];
    if ((a > 0) == (b > 0) && !(std::fabs(a - b) > s.least_jump_px)) return false;
    const auto centre = [&](std::size_t at) {
        const int x = static_cast<int>(at) % s.width, y = static_cast<int>(at) / s.width;
        return Vec2f{static_cast<float>(x) + 0.5f, static_cast<float>(y) + 0.5f};
    };
    return !discontinuities_between(s, centre(i), centre(j)).empty();
}

// True if a triangle and all its neighbours are plain.
bool is_all_plain(const Labels& labels, int t, const std::array<int, 3>& neighbours) {
    return labels.plain[t] &&
           std::all_of(neighbours.begin(), neighbours.end(), [&](int n) { return n < 0 || labels.plain[n]; });
}

void set_cut(const PlaneMesh& mesh, int t, int k, CutEdges& cut) {
    const std::uint32_t a = mesh.triangles[t][k], b = mesh.triangles[t][(k + 1) % 3];
    cut[t][k] = true;
    for (std::size_t n = 0; n < mesh.triangles.size(); ++n)
        for (int m = 0; m < 3; ++m)
            if (mesh.triangles[n][m] == b && mesh.triangles[n][(m + 1) % 3] == a) cut[n][m] = true;
}

// Calls visit(t, k, n) for edges between two kept triangles t < n that are not cut.
template <typename Visit>
void each_joined(const PlaneMesh& mesh, const Labels& labels, const CutEdges& cut, const Visit& visit) {
    const std::vector<std::array<int, 3>> neighbours = neighbours_of(mesh.triangles);
    for (int t = 0; t < static_cast<int>(mesh.triangles.size()); ++t)
        for (int k = 0; k < 3; ++k) {
            const int n = neighbours[t][k];
            if (n > t && labels.kept[t] && labels.kept[n] && !cut[t][k]) visit(t, k, n);
        }
}

// Returns, for each vertex, the number of edges on which the mesh ends there.
std::vector<int> count_border_edges(const PlaneMesh& mesh, const Labels& labels, const CutEdges& cut) {
    const std::vector<std::array<int, 3>> neighbours = neighbours_of(mesh.triangles);
    std::vector<int> counts(mesh.points.size(), 0);
    for (int t = 0; t < static_cast<int>(mesh.triangles.size()); ++t)
        for (int k = 0; k < 3; ++k) {
            const int n = neighbours[t][k];
            if (n >= 0 && n < t) continue;
            const bool other_kept = n >= 0 && labels.kept[n];
            if (labels.kept[t] == other_kept && !(labels.kept[t] && cut[t][k])) continue;
            ++counts[mesh.triangles[t][k]];
            ++counts[mesh.triangles[t][(k + 1) % 3]];
        }
    return counts;
}

}  // namespace

CutEdges vote_on_edges(const Surfaces& s, const PlaneMesh& mesh, const Labels& labels) {
    EdgeVotes votes;
    for (int y = 0; y < s.height; ++y)
        for (int x = 0; x < s.width; ++x) {
            if (x + 1 < s.width) add_vote(s, labels, {x, y, false}, votes);
            if (y + 1 < s.height) add_vote(s, labels, {x, y, true}, votes);
        }
    const std::vector<std::array<int, 3>> neighbours = neighbours_of(mesh.triangles);
    CutEdges cut(mesh.triangles.size(), {false, false, false});
    for (int t = 0; t < static_cast<int>(mesh.triangles.size()); ++t)
        for (int k = 0; k < 3; ++k) {
            const int n = neighbours[t][k];
            if (n < 0) continue;
            const auto [lower, higher] = std::minmax(t, n);
            const Votes own = votes[{lower, higher}];
            cut[t][k] = own.cut + own.joined > 0 ? own.cut > own.joined
                                                 : !is_all_plain(labels, lower, neighbours[lower]) &&
                                                       anchors_differ(s, labels, lower, higher);
        }
    return cut;
}

void join_cuts(const PlaneMesh& mesh, const Labels& labels, CutEdges& cut) {
    // counts are recomputed for each edge, because each cut changes the condition for the next
    std::vector<int> counts = count_border_edges(mesh, labels, cut);
    each_joined(mesh, labels, CutEdges(cut), [&](int t, int k, int) {
        if (counts[mesh.triangles[t][k]] != 1 || counts[mesh.triangles[t][(k + 1) % 3]] != 1) return;
        set_cut(mesh, t, k, cut);
        counts = count_border_edges(mesh, labels, cut);
    });
}

// Corners belong to one fan if their triangles share an edge at the vertex that is not cut. New vertices are
// ordered by source vertex, those of one source vertex by their first corners.
CutMesh cut_vertices(const PlaneMesh& mesh, const std::vector<bool>& kept, const CutEdges& cut) {
    const std::vector<std::array<int, 3>> neighbours = neighbours_of(mesh.triangles);
    std::vector<std::size_t> fans(3 * mesh.triangles.size());  // per corner: the first corner of its fan
    std::iota(fans.begin(), fans.end(), std::size_t{0});
    for (bool changed = true; changed;) {
        changed = false;
        for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
            for (std::size_t k = 0; k < 3; ++k) {
                const int n = neighbours[t][k];
                if (n < 0 || !kept[t] || !kept[n] || cut[t][k]) continue;
                for (const std::size_t end : {k, (k + 1) % 3}) {
                    const Triangle& other = mesh.triangles[n];
                    const auto m =
                        std::find(other.begin(), other.end(), mesh.triangles[t][end]) - other.begin();
                    std::size_t &a = fans[3 * t + end], &b = fans[3 * static_cast<std::size_t>(n) + m];
                    changed = changed || a != b;
                    a = b = std::min(a, b);
                }
            }
    }
    std::map<std::pair<std::uint32_t, std::size_t>, std::uint32_t> numbers;  // by source vertex and fan
    for (std::size_t c = 0; c < fans.size(); ++c)
        if (kept[c / 3]) numbers[{mesh.triangles[c / 3][c % 3], fans[c]}] = 0;
    CutMesh result;
    for (auto& [key, number] : numbers) {
        number = static_cast<std::uint32_t>(result.points.size());
        result.points.push_back(mesh.points[key.first]);
    }
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
        if (!kept[t]) continue;
        Triangle triangle;
        for (std::size_t k = 0; k < 3; ++k) triangle[k] = numbers[{mesh.triangles[t][k], fans[3 * t + k]}];
        result.triangles.push_back(triangle);
        result.source_triangles.push_back(static_cast<std::uint32_t>(t));
    }
    return result;
}

}  // namespace hexrelief::surface::oracle
