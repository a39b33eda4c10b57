#include "mesher/surface/topology/split_triangles.h"

#include <algorithm>
#include <atomic>
#include <numeric>

#include "mesher/surface/pixels/crack_query.h"
#include "mesher/surface/pixels/edge_crossings_step.h"
#include "mesher/surface/topology/split_triangles_step.h"

namespace hexrelief::surface {
namespace {

// Splits triangles on all threads. The parts of a triangle and their neighbours follow from its own cut and
// those of its neighbours, so threads need not wait for each other. At most two triangles meet at an edge,
// and parts of different triangles share no more edges than these did.
class Splitter {
  public:
    Splitter(SplitLattice& lattice, ThreadPool& pool)
        : lattice_(lattice), pool_(pool), before_(lattice.triangles.size()) {}

    // may_split(t): false if no edge of the triangle is to be split. place(t, k, a, b): the share of the edge
    // a -> b, a < b, at which edge k of triangle t is to be split; outside of 0 .. 1: nowhere.
    template <typename MaySplit, typename Place>
    void run(const MaySplit& may_split, const Place& place) {
        shares_.resize(before_);
        cuts_.resize(before_);
        is_cut_.assign(before_, 0);
        each(before_, [&](std::uint32_t t) {
            shares_[t] = {-1, -1, -1};
            if (!may_split(t)) return;
            for (int k = 0; k < 3; ++k) {
                if (!owns(t, k)) continue;
                const auto [a, b] = ends(t, k);
                shares_[t][k] = place(t, k, a, b);
                if (!step::splits_at(shares_[t][k])) continue;
                set_cut(t);
                if (const std::int32_t n = lattice_.neighbours[t][k]; n >= 0)
                    set_cut(static_cast<std::uint32_t>(n));
            }
        });
        each(before_, [&](std::uint32_t t) { cuts_[t] = is_cut_[t] ? find_cut(t) : step::Cut(); });
        number();
        each(cut_.size(), [&](std::uint32_t i) { split(cut_[i]); });
    }

  private:
    template <typename Visit>
    void each(std::size_t count, const Visit& visit) {
        pool_.parallel_for_chunks(count, [&](std::size_t first, std::size_t last) {
            for (std::size_t i = first; i < last; ++i) visit(static_cast<std::uint32_t>(i));
        });
    }
    // Marks a triangle as cut; several threads may do so for the same triangle.
    void set_cut(std::uint32_t t) { std::atomic_ref(is_cut_[t]).store(1, std::memory_order_relaxed); }
    // True if the triangle is the lower one of its edge k, which decides where the edge is split.
    bool owns(std::uint32_t t, int k) const {
        const std::int32_t n = lattice_.neighbours[t][k];
        return n < 0 || static_cast<std::uint32_t>(n) > t;
    }
    std::pair<std::uint32_t, std::uint32_t> ends(std::uint32_t t, int k) const {
        return std::minmax(lattice_.triangles[t][k], lattice_.triangles[t][step::turned(k, 1)]);
    }
    // Returns the cut of a triangle from the shares at which its edges are split.
    step::Cut find_cut(std::uint32_t t) const {
        unsigned edges = 0, owned = 0;
        int across[3];
        std::array<float, 3> shares;
        for (int k = 0; k < 3; ++k) {
            const std::int32_t n = lattice_.neighbours[t][k];
            across[k] = n < 0 ? 0 : step::edge_towards(lattice_.neighbours[n], static_cast<std::int32_t>(t));
            shares[k] = owns(t, k) ? shares_[t][k] : shares_[n][across[k]];
            if (!step::splits_at(shares[k])) continue;
            edges |= 1u << k;
            if (owns(t, k)) owned |= 1u << k;
        }
        if (edges == 0) return {};
        return step::cut_triangle(edges, owned, across, [&](int corner) {
            if (corner < 3) return lattice_.points[lattice_.triangles[t][corner]];
            return on_edge(t, corner - 3, shares[corner - 3]);
        });
    }
    Vec2f on_edge(std::uint32_t t, int k, float share) const {
        const auto [a, b] = ends(t, k);
        return step::between(lattice_.points[a], lattice_.points[b], share);
    }
    // Assigns numbers to the new vertices and triangles, in the order of the cut triangles.
    void number() {
        firsts_.resize(before_);
        std::uint32_t points = static_cast<std::uint32_t>(lattice_.points.size()),
                      triangles = static_cast<std::uint32_t>(before_);
        for (std::uint32_t t = 0; t < before_; ++t) {
            const step::Cut& cut = cuts_[t];
            if (cut.bits == 0) continue;
            cut_.push_back(t);
            firsts_[t] = {points, triangles};
            points += static_cast<std::uint32_t>(cut.new_points());
            triangles += static_cast<std::uint32_t>(cut.new_triangles());
        }
        lattice_.points.resize(points);
        lattice_.triangles.resize(triangles);
        lattice_.neighbours.resize(triangles);
        lattice_.changed.resize(triangles);
    }
    // Writes a triangle's parts. It reads no other triangle's corners and neighbours, and writes to uncut
    // neighbours only the link to its parts.
    void split(std::uint32_t t) {
        const step::Cut cut = cuts_[t];
        const Triangle corners = lattice_.triangles[t];
        const std::array<std::int32_t, 3> beyond = lattice_.neighbours[t];
        for (int k = 0; k < 3; ++k)
            if (cut.owned() >> k & 1u)
                lattice_.points[cut.point(k, firsts_[t].point)] = on_edge(t, k, shares_[t][k]);
        for (int part = 0; part < step::part_count(cut.edges()); ++part) {
            if (!cut.has_part(part)) continue;
            const step::PartCorners c = step::part_corners(cut, part);
            const std::uint32_t number = cut.number(part, t, firsts_[t].triangle);
            for (int i = 0; i < 3; ++i) {
                const int from = c.at[i], to = c.at[step::turned(i, 1)];
                lattice_.triangles[number][i] = vertex(cut, corners, beyond, t, from);
                lattice_.neighbours[number][i] = neighbour(cut, beyond, t, part, from, to);
            }
            if (cut.edges() != 0) lattice_.changed[number] = SplitLattice::kNew;
        }
        for (int k = 0; k < 3; ++k)
            if (beyond[k] >= 0 && cuts_[beyond[k]].bits == 0)
                lattice_.neighbours[beyond[k]][cut.edge_across(k)] =
                    number_at(static_cast<std::int32_t>(t), k, step::turned(k, 1), -1);
    }
    // Returns the number of a vertex at a corner of parts.
    std::uint32_t vertex(const step::Cut& cut, const Triangle& corners,
                         const std::array<std::int32_t, 3>& beyond, std::uint32_t t, int corner) const {
        if (corner < 3) return corners[corner];
        const int k = corner - 3;
        if (cut.owned() >> k & 1u) return cut.point(k, firsts_[t].point);
        return cuts_[beyond[k]].point(cut.edge_across(k), firsts_[beyond[k]].point);
    }
    // Returns the triangle across the edge from corner `from` to `to` of a part.
    std::int32_t neighbour(const step::Cut& cut, const std::array<std::int32_t, 3>& beyond, std::uint32_t t,
                           int part, int from, int to) const {
        const int k = step::edge_of(from, to);
        if (k < 0) return number_at(static_cast<std::int32_t>(t), from, to, part);
        if (beyond[k] < 0) return -1;
        const int j = cut.edge_across(k);
        return number_at(beyond[k], step::corner_across(from, k, j), step::corner_across(to, k, j), -1);
    }
    // Returns the number of the part of triangle t that touches both corners.
    std::int32_t number_at(std::int32_t t, int a, int b, int other_than) const {
        const step::Cut& cut = cuts_[t];
        if (cut.bits == 0) return t;
        const int part = step::part_at(cut, a, b, other_than);
        return part < 0 ? -1
                        : static_cast<std::int32_t>(
                              cut.number(part, static_cast<std::uint32_t>(t), firsts_[t].triangle));
    }

    struct Firsts {
        std::uint32_t point, triangle;  // numbers of a triangle's first new vertex and first new triangle
    };
    SplitLattice& lattice_;
    ThreadPool& pool_;
    std::size_t before_;                      // number of triangles before the split
    RawVector<std::array<float, 3>> shares_;  // shares of the edges, stored at the triangle that owns them
    std::vector<std::uint8_t> is_cut_;        // per triangle: true if one of its edges is split
    RawVector<step::Cut> cuts_;
    std::vector<std::uint32_t> cut_;  // numbers of the cut triangles
    RawVector<Firsts> firsts_;
};

// Returns the lattice's triangles of positive area and their neighbours. A slot is one of the two
// triangles of a quad.
SplitLattice open_lattice(const HexMesh2D& mesh, ThreadPool& pool) {
    SplitLattice lattice;
    lattice.points = mesh.positions;
    // numbers: of slots, -1: left out; slots: of triangles
    const int quads = std::max(0, mesh.columns - 1), rows = std::max(0, mesh.rows - 1);
    const std::size_t most = 2 * static_cast<std::size_t>(quads) * rows;
    RawVector<std::int32_t> numbers(most), slots;
    const auto each_slot = [&](int thread, const auto& visit) {
        std::size_t slot = 2 * static_cast<std::size_t>(quads) * pool.share(rows, thread);
        for (std::size_t row = pool.share(rows, thread), end = pool.share(rows, thread + 1); row < end; ++row)
            for (int column = 0; column < quads; ++column)
                for (const Triangle& t : quad_triangles(mesh.columns, column, static_cast<int>(row)))
                    visit(slot++, t);
    };
    // per thread: number of triangles of the preceding threads
    std::vector<std::int32_t> firsts(static_cast<std::size_t>(pool.size()) + 1, 0);
    pool.run([&](int thread) {
        std::int32_t kept = 0;
        each_slot(thread, [&](std::size_t slot, const Triangle& t) {
            const auto& p = mesh.positions;
            numbers[slot] = step::has_area(p[t[0]], p[t[1]], p[t[2]]) ? kept++ : -1;
        });
        firsts[static_cast<std::size_t>(thread) + 1] = kept;
    });
    std::partial_sum(firsts.begin(), firsts.end(), firsts.begin());
    const std::size_t count = static_cast<std::size_t>(firsts.back());
    // splits add a tenth to a quarter
    const std::size_t room = count + count / 4;
    lattice.triangles.reserve(room);
    lattice.neighbours.reserve(room);
    lattice.changed.reserve(room);
    lattice.points.reserve(room / 2);
    lattice.triangles.resize(count);
    slots.resize(count);
    pool.run([&](int thread) {
        each_slot(thread, [&](std::size_t slot, const Triangle& t) {
            if (numbers[slot] < 0) return;
            numbers[slot] += firsts[static_cast<std::size_t>(thread)];
            slots[static_cast<std::size_t>(numbers[slot])] = static_cast<std::int32_t>(slot);
            lattice.triangles[static_cast<std::size_t>(numbers[slot])] = t;
        });
    });
    lattice.changed.assign(lattice.triangles.size(), SplitLattice::kNew);
    lattice.neighbours.resize(lattice.triangles.size());
    pool.parallel_for_chunks(slots.size(), [&](std::size_t first, std::size_t last) {
        for (std::size_t t = first; t < last; ++t)
            for (int k = 0; k < 3; ++k) {
                const int slot = step::slot_across(mesh.columns, mesh.rows, slots[t], k);
                lattice.neighbours[t][k] = slot < 0 ? -1 : numbers[slot];
            }
    });
    return lattice;
}

}  // namespace

SplitLattice split_at_silhouettes(const PixelSurfaces& surfaces, const HexMesh2D& mesh,
                                  const std::vector<std::uint8_t>& on_silhouette, ThreadPool& pool) {
    SplitLattice lattice = open_lattice(mesh, pool);
    const CrackQuery query{surfaces.view(), surfaces.tiles()};
    const auto all = [](std::uint32_t) { return true; };
    Splitter(lattice, pool).run(all, [&](std::uint32_t, int, std::uint32_t a, std::uint32_t b) {
        const Vec2f &p = mesh.positions[a], &q = mesh.positions[b];
        return surfaces.may_cross(p, q) && surfaces.may_meet(p, q)
                   ? step::open_crossing(query, p, on_silhouette[a], q, on_silhouette[b], true)
                   : -1;
    });
    return lattice;
}

void split_straddling(const PixelSurfaces& surfaces, std::span<const std::uint8_t> straddling,
                      SplitLattice& lattice, ThreadPool& pool) {
    const CrackQuery query{surfaces.view(), surfaces.tiles()};
    const auto is_straddling = [&](std::int32_t t) { return t >= 0 && straddling[t]; };
    const auto may_split = [&](std::uint32_t t) {
        const auto& n = lattice.neighbours[t];
        return straddling[t] || is_straddling(n[0]) || is_straddling(n[1]) || is_straddling(n[2]);
    };
    Splitter(lattice, pool).run(may_split, [&](std::uint32_t t, int k, std::uint32_t a, std::uint32_t b) {
        if (!straddling[t] && !is_straddling(lattice.neighbours[t][k])) return -1.0f;
        const Vec2f &p = lattice.points[a], &q = lattice.points[b];
        if (!surfaces.may_meet(p, q)) return -1.0f;
        return step::nearer_middle(step::crossing_from_middle(query, p, q, true),
                                   step::crossing_from_middle(query, p, q, false));
    });
}

}  // namespace hexrelief::surface
