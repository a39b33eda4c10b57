#include <algorithm>
#include <numeric>

#include "mesher/buckets.h"
#include "mesher/sheet_parts.h"
#include "mesher/steps/crossings.h"

namespace hexrelief {
namespace {

constexpr float kDegenerateArea_px = 1e-4f;  // twice a triangle's area
constexpr float kLeastShare = 0.12f;         // of an edge, to its split

double twice_area(const Vec2f& a, const Vec2f& b, const Vec2f& c) {
    return (double(b.x) - a.x) * (double(c.y) - a.y) - (double(b.y) - a.y) * (double(c.x) - a.x);
}

// The edge of triangle t that it shares with `other`; -1: none.
int edge_towards(const SplitLattice& lattice, std::uint32_t t, std::int32_t other) {
    for (int k = 0; k < 3; ++k)
        if (lattice.neighbours[t][k] == other) return k;
    return -1;
}

// Makes neighbours of triangles on either side of an edge. corners: 3 * triangle + k, of all edges from
// corner k to k + 1 whose neighbours are to be found.
void pair_edges(SplitLattice& lattice, const std::vector<std::uint32_t>& corners) {
    const auto ends = [&](std::uint32_t i) {
        const Triangle& t = lattice.triangles[i / 3];
        return std::minmax(t[i % 3], t[(i % 3 + 1) % 3]);
    };
    for (const std::uint32_t i : corners) lattice.neighbours[i / 3][i % 3] = -1;
    const Buckets by_vertex = sort_into(lattice.points.size(), [&](const auto& put) {
        for (const std::uint32_t i : corners) put(ends(i).first, i);
    });
    for (std::size_t v = 0; v < lattice.points.size(); ++v) {
        const std::span<const std::uint32_t> at = by_vertex[v];
        for (std::size_t a = 0; a < at.size(); ++a)
            for (std::size_t b = a + 1; b < at.size(); ++b) {
                const std::uint32_t i = at[a], j = at[b];
                const auto first = ends(i).second, second = ends(j).second;
                if (first != second) continue;
                lattice.neighbours[i / 3][i % 3] = static_cast<std::int32_t>(j / 3);
                lattice.neighbours[j / 3][j % 3] = static_cast<std::int32_t>(i / 3);
            }
    }
}

class Splitter {
  public:
    explicit Splitter(SplitLattice& lattice) : lattice_(lattice) {}

    // place(t, k, a, b): where on its way the edge from corner k of triangle t, a -> b with a < b, is to be
    // split; anything outside of 0..1: nowhere.
    template <typename Place>
    void run(Team& team, const Place& place) {
        const std::size_t count = lattice_.triangles.size();
        std::vector<std::array<float, 3>> shares(count, {-1, -1, -1});
        team.for_ranges(count, [&](std::size_t first, std::size_t last) {
            for (std::size_t t = first; t < last; ++t)
                for (int k = 0; k < 3; ++k) {
                    const std::int32_t n = lattice_.neighbours[t][k];
                    if (n >= 0 && static_cast<std::size_t>(n) < t) continue;  // each once
                    const auto [a, b] =
                        std::minmax(lattice_.triangles[t][k], lattice_.triangles[t][(k + 1) % 3]);
                    shares[t][k] = place(t, k, a, b);
                }
        });
        middles_.assign(count, kWhole);
        for (std::uint32_t t = 0; t < count; ++t) {
            for (int k = 0; k < 3; ++k) middles_[t][k] = middle(t, k, shares[t][k]);
            if (middles_[t] == kWhole) continue;
            target_ = t;
            split(Triangle(lattice_.triangles[t]), middles_[t]);
        }
        update_neighbours();
    }

  private:
    static constexpr std::array<std::int32_t, 3> kWhole{-1, -1, -1};

    // The vertex on the edge from corner k of t; -1: none.
    std::int32_t middle(std::uint32_t t, int k, float share) {
        const std::int32_t n = lattice_.neighbours[t][k];
        if (n >= 0 && static_cast<std::uint32_t>(n) < t) return middles_[n][edge_towards(lattice_, n, t)];
        if (!(share >= kLeastShare && share <= 1 - kLeastShare)) return -1;
        const auto [a, b] = std::minmax(lattice_.triangles[t][k], lattice_.triangles[t][(k + 1) % 3]);
        const Vec2f p = lattice_.points[a], q = lattice_.points[b];
        lattice_.points.push_back({p.x + share * (q.x - p.x), p.y + share * (q.y - p.y)});
        return static_cast<std::int32_t>(lattice_.points.size() - 1);
    }
    // The first part of a triangle takes its place, the others go to the end.
    void add(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
        const auto& p = lattice_.points;
        if (!(twice_area(p[a], p[b], p[c]) > kDegenerateArea_px)) return;
        if (target_ < lattice_.triangles.size()) {
            lattice_.triangles[target_] = {a, b, c};
            lattice_.changed[target_] = SplitLattice::kNew;
            target_ = lattice_.triangles.size();  // hence push_back() from now on
            return;
        }
        lattice_.triangles.push_back({a, b, c});
        lattice_.changed.push_back(SplitLattice::kNew);
        target_ = lattice_.triangles.size();
    }
    // m: the vertex on the edge from corner k to k + 1; -1: none.
    void split(const Triangle& t, const std::array<std::int32_t, 3>& m) {
        const int count = (m[0] >= 0) + (m[1] >= 0) + (m[2] >= 0);
        const auto on = [&](int k) { return static_cast<std::uint32_t>(m[k % 3]); };
        if (count == 3) {
            for (int k = 0; k < 3; ++k) add(t[k], on(k), on(k + 2));
            return add(on(0), on(1), on(2));
        }
        int k = 0;  // the corner before the only split edge, or between the two split ones
        if (count == 1)
            while (m[k] < 0) ++k;
        else
            while (m[(k + 1) % 3] >= 0) ++k;
        const std::uint32_t a = t[k], b = t[(k + 1) % 3], c = t[(k + 2) % 3];
        if (count == 1) {
            add(a, on(k), c);
            return add(on(k), b, c);
        }
        const std::uint32_t ab = on(k), ca = on(k + 2);
        add(a, ab, ca);
        // the shorter diagonal of the other side
        const auto distance2 = [&](std::uint32_t i, std::uint32_t j) {
            const Vec2f &u = lattice_.points[i], &v = lattice_.points[j];
            return (u.x - v.x) * (u.x - v.x) + (u.y - v.y) * (u.y - v.y);
        };
        if (distance2(ab, c) <= distance2(b, ca)) {
            add(ab, b, c);
            add(ab, c, ca);
        } else {
            add(ab, b, ca);
            add(b, c, ca);
        }
    }

    // All edges of the triangles that were split, and those of whole ones that meet them.
    void update_neighbours() {
        const std::uint32_t before = static_cast<std::uint32_t>(middles_.size()),
                            count = static_cast<std::uint32_t>(lattice_.triangles.size());
        const auto whole = [&](std::int32_t t) { return middles_[t] == kWhole; };
        std::vector<std::uint32_t> corners;
        for (std::uint32_t t = 0; t < before; ++t) {
            if (whole(static_cast<std::int32_t>(t))) continue;
            for (std::uint32_t k = 0; k < 3; ++k) {
                const std::int32_t n = lattice_.neighbours[t][k];
                corners.push_back(3 * t + k);
                if (n >= 0 && whole(n))
                    corners.push_back(3 * static_cast<std::uint32_t>(n) + edge_towards(lattice_, n, t));
            }
        }
        for (std::uint32_t i = 3 * before; i < 3 * count; ++i) corners.push_back(i);
        lattice_.neighbours.resize(count);
        pair_edges(lattice_, corners);
    }

    SplitLattice& lattice_;
    std::size_t target_ = 0;
    std::vector<std::array<std::int32_t, 3>> middles_;  // of the triangles before
};

}  // namespace

SplitLattice split_at_rims(const PixelSurfaces& surfaces, const HexMesh2D& mesh,
                           const std::vector<std::uint8_t>& on_rim, Team& team) {
    SplitLattice lattice;
    lattice.points = mesh.positions;
    for (int row = 0; row + 1 < mesh.rows; ++row)
        for (int column = 0; column + 1 < mesh.columns; ++column)
            for (const Triangle& t : quad_triangles(mesh.columns, column, row)) {
                const auto& p = mesh.positions;
                if (twice_area(p[t[0]], p[t[1]], p[t[2]]) > kDegenerateArea_px)
                    lattice.triangles.push_back(t);
            }
    lattice.changed.assign(lattice.triangles.size(), SplitLattice::kNew);
    lattice.neighbours.resize(lattice.triangles.size());
    std::vector<std::uint32_t> corners(3 * lattice.triangles.size());
    std::iota(corners.begin(), corners.end(), std::uint32_t{0});
    pair_edges(lattice, corners);
    const step::PixelLook look{surfaces.view()};
    Splitter(lattice).run(team, [&](std::size_t, int, std::uint32_t a, std::uint32_t b) {
        const Vec2f &p = mesh.positions[a], &q = mesh.positions[b];
        return surfaces.may_cross(p, q) ? step::open_crossing(look, p, on_rim[a], q, on_rim[b]) : -1;
    });
    return lattice;
}

void split_mixed(const PixelSurfaces& surfaces, const TriangleSides& sides, SplitLattice& lattice,
                 Team& team) {
    const step::PixelLook look{surfaces.view()};
    Splitter(lattice).run(team, [&](std::size_t t, int k, std::uint32_t a, std::uint32_t b) {
        const std::int32_t n = lattice.neighbours[t][k];
        if (!sides.mixed[t] && !(n >= 0 && sides.mixed[n])) return -1.0f;
        return step::middle_crossing(look, lattice.points[a], lattice.points[b]);
    });
}

}  // namespace hexrelief
