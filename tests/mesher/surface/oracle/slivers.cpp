// Step 16: slivers that span a step which their surface does not have.
#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "parts.h"

namespace hexrelief::oracle {
namespace {

// A triangle of at most 1.5 px2 that rises by more than a jump, and by more than its own pixels' width along
// a row or a column, which both cameras could not see.
bool is_sliver(const Mesh& mesh, const Triangle& t, double least_jump_px) {
    const auto& [a, b, c] = t;
    const double rise_b = double(mesh.disparities[b]) - mesh.disparities[a],
                 rise_c = double(mesh.disparities[c]) - mesh.disparities[a];
    if (std::max({0.0, rise_b, rise_c}) - std::min({0.0, rise_b, rise_c}) <= least_jump_px) return false;
    const double bx = double(mesh.points[b].x) - mesh.points[a].x,
                 by = double(mesh.points[b].y) - mesh.points[a].y,
                 cx = double(mesh.points[c].x) - mesh.points[a].x,
                 cy = double(mesh.points[c].y) - mesh.points[a].y;
    const double area2 = std::fabs(bx * cy - cx * by);
    if (area2 > 2 * 1.5) return false;
    return std::fabs(rise_b * cy - rise_c * by) > area2 || std::fabs(rise_c * bx - rise_b * cx) > area2;
}

void drop_unused_vertices(Mesh& mesh) {
    std::set<std::uint32_t> used;
    for (const Triangle& t : mesh.triangles) used.insert(t.begin(), t.end());
    Mesh kept;
    std::map<std::uint32_t, std::uint32_t> number;
    for (const std::uint32_t v : used) {
        number[v] = static_cast<std::uint32_t>(kept.points.size());
        kept.points.push_back(mesh.points[v]);
        kept.disparities.push_back(mesh.disparities[v]);
    }
    for (const Triangle& t : mesh.triangles)
        kept.triangles.push_back({number[t[0]], number[t[1]], number[t[2]]});
    for (const std::uint32_t v : mesh.non_manifold)
        if (used.contains(v)) kept.non_manifold.push_back(number[v]);
    mesh = kept;
}

}  // namespace

// Vertices of slivers may then hold several fans.
void drop_slivers(double least_jump_px, Mesh& mesh) {
    std::set<std::uint32_t> touched;
    for (const Triangle& t : mesh.triangles)
        if (is_sliver(mesh, t, least_jump_px)) touched.insert(t.begin(), t.end());
    if (touched.empty()) return;
    std::erase_if(mesh.triangles, [&](const Triangle& t) { return is_sliver(mesh, t, least_jump_px); });
    mesh.non_manifold.assign(touched.begin(), touched.end());
    drop_unused_vertices(mesh);
}

}  // namespace hexrelief::oracle
