// Step 6: lattice vertices move onto silhouettes.
#include <algorithm>
#include <map>
#include <optional>

#include "oracle_parts.h"

namespace hexrelief::surface::oracle {
namespace {

// Returns the neighbour in direction k, east first, then by rising row: clockwise as the image shows it.
// -1: beyond the border.
int lattice_neighbour(const HexMesh2D& lattice, int v, int k) {
    constexpr int kRows[6] = {0, 1, 1, 0, -1, -1}, kEvenColumns[6] = {1, 0, -1, -1, -1, 0},
                  kOddColumns[6] = {1, 1, 0, -1, 0, 1};
    const int column = v % lattice.columns, row = v / lattice.columns;
    const int c = column + (row % 2 == 0 ? kEvenColumns[k] : kOddColumns[k]), r = row + kRows[k];
    return c < 0 || r < 0 || c >= lattice.columns || r >= lattice.rows ? -1 : r * lattice.columns + c;
}

// Returns 1 for an equilateral triangle, 0 for a degenerate one, a negative value for an inverted one.
float shape_of(const Vec2f& a, const Vec2f& b, const Vec2f& c) {
    const float abx = b.x - a.x, aby = b.y - a.y, acx = c.x - a.x, acy = c.y - a.y, bcx = c.x - b.x,
                bcy = c.y - b.y;
    const float sum = abx * abx + aby * aby + acx * acx + acy * acy + bcx * bcx + bcy * bcy;
    return sum > 0 ? 3.4641016f * (abx * acy - aby * acx) / sum : 0;
}

// Returns the worst shape of the triangles at vertex v, at most 1.
float worst_shape_at(const HexMesh2D& lattice, std::uint32_t v) {
    float worst = 1;
    for (int row = 0; row + 1 < lattice.rows; ++row)
        for (int column = 0; column + 1 < lattice.columns; ++column) {
            const int own = static_cast<int>(v) / lattice.columns;
            if (row != own && row + 1 != own) continue;
            for (const Triangle& t : quad_triangles(lattice.columns, column, row))
                if (std::find(t.begin(), t.end(), v) != t.end())
                    worst = std::min(worst, shape_of(lattice.positions[t[0]], lattice.positions[t[1]],
                                                     lattice.positions[t[2]]));
        }
    return worst;
}

// Vertices that are equally far from their crossings are ordered by this hash.
std::uint32_t hash_of(std::uint32_t v) {
    v *= 2654435761u;
    v ^= v >> 15;
    v *= 2246822519u;
    return v ^ v >> 13;
}

struct Crossing {
    float share;  // share of the edge
    Vec2f point;
};

// Returns, of the crossings on the edges at vertex v, the one at the least share of its edge, the
// first of equal ones.
std::optional<Crossing> nearest_crossing(const Surfaces& s, const HexMesh2D& lattice,
                                         const std::vector<bool>& on_silhouette, int v) {
    std::optional<Crossing> nearest;
    for (int k = 0; k < 6; ++k) {
        const int u = lattice_neighbour(lattice, v, k);
        if (u < 0) continue;
        const Vec2f &p = lattice.positions[v], &q = lattice.positions[u];
        const float share = edge_crossing(s, p, false, q, on_silhouette[u], v < u);
        if (share >= 0 && (!nearest || share < nearest->share)) nearest = {share, between(p, q, share)};
    }
    return nearest;
}

// Returns the position that the border allows a vertex: moved along it, or none from its corners.
std::optional<Vec2f> allowed_by_border(const Surfaces& s, const Vec2f& from, Vec2f to) {
    const float width = static_cast<float>(s.width), height = static_cast<float>(s.height);
    const bool side = from.x <= 0 || from.x >= width, end = from.y <= 0 || from.y >= height;
    if (side && end) return std::nullopt;
    if (side) to.x = from.x;
    if (end) to.y = from.y;
    return Vec2f{std::clamp(to.x, 0.0f, width), std::clamp(to.y, 0.0f, height)};
}

// Moves a vertex, unless that leaves a triangle of a shape below 0.3 and worse than the worst one before.
bool try_move(const Surfaces& s, HexMesh2D& lattice, int v, const Vec2f& wanted) {
    Vec2f& p = lattice.positions[v];
    const Vec2f from = p;
    const std::optional<Vec2f> to = allowed_by_border(s, from, wanted);
    if (!to) return false;
    const float before = worst_shape_at(lattice, static_cast<std::uint32_t>(v));
    p = *to;
    const float after = worst_shape_at(lattice, static_cast<std::uint32_t>(v));
    if (after >= 0.3f || after >= before) return true;
    p = from;
    return false;
}

}  // namespace

// Visits the vertices whose crossing is within 0.75 of their edge, nearest first.
std::vector<bool> snap_vertices(const Surfaces& s, HexMesh2D& lattice) {
    constexpr float kReach = 0.75f;
    std::vector<bool> on_silhouette(lattice.positions.size(), false);
    std::map<std::pair<float, std::uint32_t>, int> order;
    for (int v = 0; v < static_cast<int>(lattice.positions.size()); ++v) {
        const auto crossing = nearest_crossing(s, lattice, on_silhouette, v);
        if (crossing && crossing->share <= kReach)
            order[{crossing->share, hash_of(static_cast<std::uint32_t>(v))}] = v;
    }
    for (const auto& [place, v] : order) {
        const auto crossing = nearest_crossing(s, lattice, on_silhouette, v);  // neighbours may have moved
        if (!crossing || !(crossing->share <= kReach)) continue;
        const Vec2f nearest = nearest_silhouette_point(s, lattice.positions[v], crossing->point);
        on_silhouette[v] = try_move(s, lattice, v, nearest) || try_move(s, lattice, v, crossing->point);
    }
    return on_silhouette;
}

}  // namespace hexrelief::surface::oracle
