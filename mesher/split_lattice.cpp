#include <algorithm>
#include <functional>
#include <unordered_map>
#include <unordered_set>

#include "mesher/align.h"
#include "mesher/sheet_parts.h"

namespace hexrelief {
namespace {

constexpr float kDegenerateArea_px = 1e-4f;  // twice a triangle's area
constexpr float kLeastShare = 0.12f;         // of an edge, to its split

double twice_area(const Vec2f& a, const Vec2f& b, const Vec2f& c) {
    return (double(b.x) - a.x) * (double(c.y) - a.y) - (double(b.y) - a.y) * (double(c.x) - a.x);
}

// Where on its way an edge is to be split; anything outside of 0..1: nowhere.
using SplitPlace = std::function<float(std::uint32_t, std::uint32_t)>;

class Splitter {
  public:
    Splitter(SplitLattice& lattice, const SplitPlace& place) : lattice_(lattice), place_(place) {}

    void run() {
        const std::size_t count = lattice_.triangles.size();
        for (std::size_t t = 0; t < count; ++t) {
            target_ = t;
            split(Triangle(lattice_.triangles[t]));
        }
    }

  private:
    // The vertex on the edge a - b; -1: none.
    std::int32_t middle(std::uint32_t a, std::uint32_t b) {
        if (a > b) std::swap(a, b);
        const std::uint64_t key = std::uint64_t{a} << 32 | b;
        const auto found = middles_.find(key);
        if (found != middles_.end()) return found->second;
        const float t = place_(a, b);
        std::int32_t vertex = -1;
        if (t >= kLeastShare && t <= 1 - kLeastShare) {
            vertex = static_cast<std::int32_t>(lattice_.points.size());
            const Vec2f p = lattice_.points[a], q = lattice_.points[b];
            lattice_.points.push_back({p.x + t * (q.x - p.x), p.y + t * (q.y - p.y)});
        }
        middles_.emplace(key, vertex);
        return vertex;
    }
    // The first part of a triangle takes its place, the others go to the end.
    void add(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
        const auto& p = lattice_.points;
        if (!(twice_area(p[a], p[b], p[c]) > kDegenerateArea_px)) return;
        if (target_ < lattice_.triangles.size()) {
            lattice_.triangles[target_] = {a, b, c};
            lattice_.changed[target_] = 1;
            target_ = lattice_.triangles.size();  // hence push_back() from now on
            return;
        }
        lattice_.triangles.push_back({a, b, c});
        lattice_.changed.push_back(1);
        target_ = lattice_.triangles.size();
    }
    void split(const Triangle& t) {
        std::array<std::int32_t, 3> m;  // on the edge from corner k to k + 1
        int count = 0;
        for (int k = 0; k < 3; ++k) count += (m[k] = middle(t[k], t[(k + 1) % 3])) >= 0;
        const auto on = [&](int k) { return static_cast<std::uint32_t>(m[k % 3]); };
        if (count == 0) return;
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

    SplitLattice& lattice_;
    const SplitPlace& place_;
    std::size_t target_ = 0;
    std::unordered_map<std::uint64_t, std::int32_t> middles_;
};

// Pairs the two triangles of each edge, by buckets of the edges' lower vertices.
void find_neighbours(SplitLattice& lattice) {
    const std::size_t corners = 3 * lattice.triangles.size();
    std::vector<std::uint32_t> starts(lattice.points.size() + 1, 0), items(corners);
    const auto ends = [&](std::uint32_t i) {
        const Triangle& t = lattice.triangles[i / 3];
        return std::minmax(t[i % 3], t[(i % 3 + 1) % 3]);
    };
    for (std::uint32_t i = 0; i < corners; ++i) ++starts[ends(i).first + 1];
    for (std::size_t v = 1; v < starts.size(); ++v) starts[v] += starts[v - 1];
    std::vector<std::uint32_t> next(starts.begin(), starts.end() - 1);
    for (std::uint32_t i = 0; i < corners; ++i) items[next[ends(i).first]++] = i;
    lattice.neighbours.assign(lattice.triangles.size(), {-1, -1, -1});
    for (std::size_t v = 0; v + 1 < starts.size(); ++v)
        for (std::uint32_t a = starts[v]; a < starts[v + 1]; ++a)
            for (std::uint32_t b = a + 1; b < starts[v + 1]; ++b) {
                const std::uint32_t i = items[a], j = items[b];
                const auto first = ends(i).second, second = ends(j).second;
                if (first != second) continue;
                lattice.neighbours[i / 3][i % 3] = static_cast<std::int32_t>(j / 3);
                lattice.neighbours[j / 3][j % 3] = static_cast<std::int32_t>(i / 3);
            }
}

}  // namespace

SplitLattice split_at_rims(const PixelSurfaces& surfaces, const HexMesh2D& mesh,
                           const std::vector<std::uint8_t>& on_rim) {
    SplitLattice lattice;
    lattice.points = mesh.positions;
    for (int row = 0; row + 1 < mesh.rows; ++row)
        for (int column = 0; column + 1 < mesh.columns; ++column)
            for (const Triangle& t : quad_triangles(mesh.columns, column, row)) {
                const auto& p = mesh.positions;
                if (twice_area(p[t[0]], p[t[1]], p[t[2]]) > kDegenerateArea_px)
                    lattice.triangles.push_back(t);
            }
    const SplitPlace place = [&](std::uint32_t a, std::uint32_t b) {
        return open_crossing(surfaces, mesh.positions[a], on_rim[a], mesh.positions[b], on_rim[b]);
    };
    lattice.changed.assign(lattice.triangles.size(), 1);
    Splitter(lattice, place).run();
    find_neighbours(lattice);
    return lattice;
}

void split_mixed(const PixelSurfaces& surfaces, const TriangleSides& sides, SplitLattice& lattice) {
    std::unordered_set<std::uint64_t> edges;  // of mixed triangles, lower vertex first
    for (std::size_t t = 0; t < lattice.triangles.size(); ++t) {
        if (!sides.mixed[t]) continue;
        for (int k = 0; k < 3; ++k) {
            const auto [a, b] = std::minmax(lattice.triangles[t][k], lattice.triangles[t][(k + 1) % 3]);
            edges.insert(std::uint64_t{a} << 32 | b);
        }
    }
    const SplitPlace place = [&, view = surfaces.view()](std::uint32_t a, std::uint32_t b) {
        if (!edges.contains(std::uint64_t{a} << 32 | b)) return -1.0f;
        return middle_crossing(view, lattice.points[a], lattice.points[b]);
    };
    Splitter(lattice, place).run();
    find_neighbours(lattice);
}

}  // namespace hexrelief
