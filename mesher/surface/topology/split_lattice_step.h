// Opens the lattice and splits its triangles at given places, by a team of threads.
#pragma once

#include <cstddef>
#include <cstdint>

#include "mesher/surface/pixels/edge_crossings_step.h"
#include "mesher/surface/topology/split_triangles_step.h"
#include "pipeline/base/shared_memory_step.h"
#include "pipeline/data/hex_mesh.h"

namespace hexrelief::step {

enum Change : std::uint8_t { kSame, kMoved, kNew };  // of a triangle since it was last labelled

// Neighbours: type of a pointer to three triangles per triangle: those across the edges from corner k to k +
// 1, -1: none.
template <typename Neighbours>
struct SplitView {
    Vec2f* points;  // the lattice's vertices, then those put on edges
    Triangle* triangles;
    Neighbours neighbours;
    std::uint8_t* changed;  // per triangle: Change
};

struct LatticeCounts {
    unsigned points, triangles;
};

struct SplitArrays {
    float (*shares)[3];     // per triangle: the shares at which its edges are split; all -1 between calls
    Cut* cuts;              // per triangle
    LatticeCounts* firsts;  // per triangle that is cut: numbers of its first new vertex and triangle
    std::uint32_t* list;    // the triangles that are cut, in no particular order
    unsigned* count;        // number of these
};

HEXRELIEF_HD unsigned slot_count(int columns, int rows) {
    return columns < 2 || rows < 2 ? 0
                                   : 2 * static_cast<unsigned>(columns - 1) * static_cast<unsigned>(rows - 1);
}
// Returns the triangle of a slot, see slot_across().
HEXRELIEF_HD Triangle corners_of_slot(int columns, unsigned slot) {
    const unsigned quad = slot / 2, quads = static_cast<unsigned>(columns - 1);
    return quad_triangles(columns, static_cast<int>(quad % quads), static_cast<int>(quad / quads))[slot & 1];
}

// Numbers the lattice's triangles of positive area; inverted and degenerate ones are left out. numbers: per
// slot, -1: left out. Returns how many there are.
template <typename Team>
HEXRELIEF_TEAM unsigned number_slots(const Team& team, int columns, int rows, const Vec2f* points,
                                     std::int32_t* numbers) {
    const auto is_kept = [&](std::size_t slot) -> unsigned {
        const Triangle t = corners_of_slot(columns, static_cast<unsigned>(slot));
        return has_area(points[t[0]], points[t[1]], points[t[2]]) ? 1 : 0;
    };
    return exclusive_scan(team, slot_count(columns, rows), is_kept, [&](std::size_t slot, unsigned before) {
        numbers[slot] = is_kept(slot) ? static_cast<std::int32_t>(before) : -1;
    });
}
// Writes the numbered triangles, with their neighbours.
template <typename Team, typename View>
HEXRELIEF_TEAM void write_slots(const Team& team, int columns, int rows, const std::int32_t* numbers,
                                const View& lattice) {
    team.each(slot_count(columns, rows), [&](std::size_t slot) {
        const std::int32_t t = numbers[slot];
        if (t < 0) return;
        lattice.triangles[t] = corners_of_slot(columns, static_cast<unsigned>(slot));
        lattice.changed[t] = kNew;
        for (int k = 0; k < 3; ++k) {
            const int across = slot_across(columns, rows, static_cast<int>(slot), k);
            lattice.neighbours[t][k] = across < 0 ? -1 : numbers[across];
        }
    });
}

// The edge from corner k of a triangle to the next one: its ends, a < b, and their places.
struct SplitEdge {
    std::uint32_t a, b;
    Vec2f p, q;
};

// The parts of a triangle and their neighbours follow from its own cut and those of its neighbours, so
// threads need not wait for each other. At most two triangles meet at an edge, and parts of different
// triangles share no more edges than these did.
template <typename View>
class LatticeSplitter {
  public:
    HEXRELIEF_TEAM LatticeSplitter(const View& lattice, const SplitArrays& arrays)
        : l_(lattice), a_(arrays) {}

    HEXRELIEF_TEAM const View& lattice() const { return l_; }
    // True if the triangle is the lower one of its edge k, which decides where the edge is split.
    HEXRELIEF_TEAM bool owns(std::int32_t t, int k) const {
        const std::int32_t n = l_.neighbours[t][k];
        return n < 0 || n > t;
    }
    HEXRELIEF_TEAM SplitEdge edge(std::int32_t t, int k) const {
        const Triangle& corners = l_.triangles[t];
        const std::uint32_t u = corners[k], v = corners[turned(k, 1)], a = min_of(u, v), b = max_of(u, v);
        return {a, b, l_.points[a], l_.points[b]};
    }
    // Splits edge k of the triangle that owns it at a share of the way from its lower end; nowhere if it is
    // outside of 0 .. 1. True if it is split.
    HEXRELIEF_TEAM bool put_share(std::int32_t t, int k, float share) const {
        if (!splits_at(share)) return false;
        a_.shares[t][k] = share;
        if (const std::int32_t n = l_.neighbours[t][k]; n >= 0)
            a_.shares[n][edge_towards(l_.neighbours[n], t)] = share;
        return true;
    }
    template <typename Team>
    HEXRELIEF_TEAM void clear_shares(const Team& team, unsigned triangles) const {
        team.each(triangles,
                  [&](std::size_t t) { a_.shares[t][0] = a_.shares[t][1] = a_.shares[t][2] = -1; });
    }
    // Numbers the new vertices and triangles, in the order of the cut triangles. Returns how many there are
    // of both after the split.
    template <typename Team>
    HEXRELIEF_TEAM LatticeCounts number(const Team& team, const LatticeCounts& before) const {
        if (team.is_first()) *a_.count = 0;
        team.each(before.triangles,
                  [&](std::size_t t) { a_.cuts[t] = cut_of(static_cast<std::int32_t>(t)); });
        const std::uint64_t all = exclusive_scan(
            team, before.triangles,
            [&](std::size_t t) {  // points in the upper half, triangles in the lower half
                return static_cast<unsigned long long>(a_.cuts[t].new_points()) << 32 |
                       static_cast<unsigned>(a_.cuts[t].new_triangles());
            },
            [&](std::size_t t, std::uint64_t first) {
                if (a_.cuts[t].bits == 0) return;
                a_.firsts[t] = {before.points + static_cast<unsigned>(first >> 32),
                                before.triangles + static_cast<unsigned>(first)};
                a_.list[add_to(a_.count, 1)] = static_cast<std::uint32_t>(t);
            });
        return {before.points + static_cast<unsigned>(all >> 32),
                before.triangles + static_cast<unsigned>(all)};
    }
    // Writes the parts of the numbered triangles, and clears the shares.
    template <typename Team>
    HEXRELIEF_TEAM void split(const Team& team) const {
        team.each(*a_.count, [&](std::size_t i) { split(static_cast<std::int32_t>(a_.list[i])); });
    }

  private:
    HEXRELIEF_TEAM Vec2f on_edge(std::int32_t t, int k) const {
        const SplitEdge e = edge(t, k);
        return between(e.p, e.q, a_.shares[t][k]);
    }
    // Returns the cut of a triangle from the shares at which its edges are split.
    HEXRELIEF_TEAM Cut cut_of(std::int32_t t) const {
        unsigned edges = 0, owned = 0;
        for (int k = 0; k < 3; ++k)
            if (splits_at(a_.shares[t][k])) edges |= 1u << k;
        if (edges == 0) return {};
        int across[3];
        Vec2f places[6];
        HEXRELIEF_UNROLL
        for (int k = 0; k < 3; ++k) {
            const std::int32_t n = l_.neighbours[t][k];
            across[k] = n < 0 ? 0 : edge_towards(l_.neighbours[n], t);
            if (owns(t, k)) owned |= edges & 1u << k;
            places[k] = l_.points[l_.triangles[t][k]];
            places[3 + k] = on_edge(t, k);
        }
        return cut_triangle(edges, owned, across, [&](int corner) { return places[corner]; });
    }
    // Writes a triangle's parts. It reads no other triangle's corners and neighbours, and writes to uncut
    // neighbours only the link to its parts.
    HEXRELIEF_TEAM void split(std::int32_t t) const {
        const Cut cut = a_.cuts[t];
        const LatticeCounts first = a_.firsts[t];
        const Triangle corners = l_.triangles[t];
        const std::int32_t beyond[3] = {l_.neighbours[t][0], l_.neighbours[t][1], l_.neighbours[t][2]};
        for (int k = 0; k < 3; ++k)
            if (cut.owned() >> k & 1u) l_.points[cut.point(k, first.points)] = on_edge(t, k);
        for (int part = 0; part < part_count(cut.edges()); ++part) {
            if (!cut.has_part(part)) continue;
            const PartCorners c = part_corners(cut, part);
            const std::uint32_t number = cut.number(part, static_cast<std::uint32_t>(t), first.triangles);
            for (int i = 0; i < 3; ++i) {
                const int from = c.at[i], to = c.at[turned(i, 1)];
                l_.triangles[number][i] = vertex(cut, corners, beyond, first, from);
                l_.neighbours[number][i] = neighbour(cut, beyond, t, part, from, to);
                a_.shares[number][i] = -1;
            }
            if (cut.edges() != 0) l_.changed[number] = kNew;
        }
        for (int k = 0; k < 3; ++k) {
            a_.shares[t][k] = -1;
            if (beyond[k] >= 0 && a_.cuts[beyond[k]].bits == 0)
                l_.neighbours[beyond[k]][cut.edge_across(k)] = number_at(t, k, turned(k, 1), -1);
        }
    }
    // Returns the number of a vertex at a corner of parts.
    HEXRELIEF_TEAM std::uint32_t vertex(const Cut& cut, const Triangle& corners, const std::int32_t beyond[3],
                                        const LatticeCounts& first, int corner) const {
        if (corner < 3) return corners[corner];
        const int k = corner - 3;
        if (cut.owned() >> k & 1u) return cut.point(k, first.points);
        return a_.cuts[beyond[k]].point(cut.edge_across(k), a_.firsts[beyond[k]].points);
    }
    // Returns the triangle across the edge from corner `from` to `to` of a part.
    HEXRELIEF_TEAM std::int32_t neighbour(const Cut& cut, const std::int32_t beyond[3], std::int32_t t,
                                          int part, int from, int to) const {
        const int k = edge_of(from, to);
        if (k < 0) return number_at(t, from, to, part);
        if (beyond[k] < 0) return -1;
        const int j = cut.edge_across(k);
        return number_at(beyond[k], corner_across(from, k, j), corner_across(to, k, j), -1);
    }
    // Returns the number of the part of triangle t that touches both corners.
    HEXRELIEF_TEAM std::int32_t number_at(std::int32_t t, int a, int b, int other_than) const {
        const Cut cut = a_.cuts[t];
        if (cut.bits == 0) return t;
        const int part = part_at(cut, a, b, other_than);
        return part < 0 ? -1
                        : static_cast<std::int32_t>(
                              cut.number(part, static_cast<std::uint32_t>(t), a_.firsts[t].triangles));
    }

    View l_;
    SplitArrays a_;
};

}  // namespace hexrelief::step
