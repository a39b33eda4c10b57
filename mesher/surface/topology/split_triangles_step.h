// How a triangle is cut into parts by vertices that are put on its edges, and which parts lie next to each
// other.
#pragma once

#include <cstdint>

#include "mesher/common/host_device.h"
#include "mesher/common/surface_thresholds_step.h"
#include "pipeline/data/geometry.h"
#include "pipeline/data/hex_mesh.h"

namespace hexrelief::step {

HEXRELIEF_HD bool has_area(const Vec2f& a, const Vec2f& b, const Vec2f& c) {
    return (double(b.x) - a.x) * (double(c.y) - a.y) - (double(b.y) - a.y) * (double(c.x) - a.x) >
           kDegenerateArea_px;
}

HEXRELIEF_HD bool splits_at(float share) {
    return share >= kLeastShare && share <= 1 - kLeastShare;
}

// Of four bits.
HEXRELIEF_HD int bit_count(unsigned bits) {
#ifdef __CUDA_ARCH__
    return __popc(bits);
#else
    return static_cast<int>(0x4332322132212110u >> (4 * bits) & 7u);
#endif
}

HEXRELIEF_HD int turned(int k, int by) {
    return k + by < 3 ? k + by : k + by - 3;
}

// Which of a triangle's three edges leads to a neighbour; -1: none.
template <typename Neighbours>
HEXRELIEF_HD int edge_towards(const Neighbours& neighbours, std::int32_t other) {
    HEXRELIEF_ROLLED
    for (int k = 0; k < 3; ++k)
        if (neighbours[k] == other) return k;
    return -1;
}

// Corners of parts: 0 .. 2 are the triangle's own, 3 + k is the vertex on the edge from corner k to k + 1.
struct PartCorners {
    int at[3];
};

// A triangle that is cut. The first part that has an area takes the triangle's place, others are new
// triangles; where none has one, the triangle stays as it was.
struct Cut {
    std::uint32_t bits = 0;  // 0: the triangle is left alone

    // Edges that the parts end on; whether the longer diagonal parts them; those with an area; the edges
    // whose new vertex this triangle numbers; which edge of the neighbour across each edge is the same.
    HEXRELIEF_HD unsigned edges() const { return bits & 7u; }
    HEXRELIEF_HD bool other_diagonal() const { return bits >> 3 & 1u; }
    HEXRELIEF_HD unsigned kept() const { return bits >> 4 & 15u; }
    HEXRELIEF_HD unsigned owned() const { return bits >> 8 & 7u; }
    HEXRELIEF_HD int edge_across(int k) const { return static_cast<int>(bits >> (12 + 2 * k) & 3u); }

    HEXRELIEF_HD int new_triangles() const { return bits == 0 ? 0 : bit_count(kept()) - 1; }
    HEXRELIEF_HD int new_points() const { return bit_count(owned()); }
    HEXRELIEF_HD bool has_part(int part) const { return kept() >> part & 1u; }
    // Whose place in the order of new triangles begins at first_new.
    HEXRELIEF_HD std::uint32_t number(int part, std::uint32_t triangle, std::uint32_t first_new) const {
        const int rank = bit_count(kept() & ((1u << part) - 1));
        return rank == 0 ? triangle : first_new + static_cast<std::uint32_t>(rank) - 1;
    }
    // Of the vertex on an edge that this triangle numbers.
    HEXRELIEF_HD std::uint32_t point(int edge, std::uint32_t first_point) const {
        return first_point + static_cast<std::uint32_t>(bit_count(owned() & ((1u << edge) - 1)));
    }
};

HEXRELIEF_HD int part_count(unsigned edges) {
    return 1 + bit_count(edges);
}

HEXRELIEF_HD PartCorners part_corners(unsigned edges, bool other_diagonal, int part) {
    // a digit a corner, parts from the right; of one edge split that is edge 0, of two those are 0 and 2
    const std::uint64_t parts = edges == 0                   ? 012
                                : edges == 7                 ? 0345'254'143'035
                                : (edges & (edges - 1)) == 0 ? 0312'032
                                                             : (other_diagonal ? 0125'315'035 : 0325'312'035);
    const int by = edges == 2 || edges == 3 ? 1 : edges == 4 || edges == 6 ? 2 : 0;
    PartCorners corners;
    for (int i = 0; i < 3; ++i) {
        const int digit = static_cast<int>(parts >> (9 * part + 3 * (2 - i)) & 7u);
        corners.at[i] = digit < 3 ? turned(digit, by) : 3 + turned(digit - 3, by);
    }
    return corners;
}

HEXRELIEF_HD PartCorners part_corners(const Cut& cut, int part) {
    return part_corners(cut.edges(), cut.other_diagonal(), part);
}

// The part at both of two corners, other than one of them; -1: none.
HEXRELIEF_HD int part_at(const Cut& cut, int a, int b, int other_than) {
    HEXRELIEF_ROLLED
    for (int part = 0; part < 4; ++part) {
        if (part == other_than || !cut.has_part(part)) continue;
        const PartCorners c = part_corners(cut, part);
        const unsigned corners = 1u << c.at[0] | 1u << c.at[1] | 1u << c.at[2];
        if ((corners >> a & 1u) && (corners >> b & 1u)) return part;
    }
    return -1;
}

// The triangle's edge that both corners lie on; -1: they lie across it.
HEXRELIEF_HD int edge_of(int a, int b) {
    HEXRELIEF_ROLLED
    for (int k = 0; k < 3; ++k) {
        const unsigned on = 1u << k | 1u << turned(k, 1) | 1u << (3 + k);
        if ((on >> a & 1u) && (on >> b & 1u)) return k;
    }
    return -1;
}

// A corner on edge k as the neighbour across numbers it, whose edge j it is.
HEXRELIEF_HD int corner_across(int corner, int k, int j) {
    return corner >= 3 ? 3 + j : corner == k ? turned(j, 1) : j;
}

// edges: those with a new vertex, not 0; owned, across: see Cut; place(corner): of a corner of parts.
template <typename Place>
HEXRELIEF_HD Cut cut_triangle(unsigned edges, unsigned owned, const int across[3], const Place& place) {
    bool other_diagonal = false;
    if (bit_count(edges) == 2) {
        const int k = edges == 5 ? 0 : edges == 3 ? 1 : 2;  // the corner between the split edges
        const auto distance2 = [&](int i, int j) {
            const Vec2f u = place(i), v = place(j);
            return (u.x - v.x) * (u.x - v.x) + (u.y - v.y) * (u.y - v.y);
        };
        other_diagonal = !(distance2(3 + k, turned(k, 2)) <= distance2(turned(k, 1), 3 + turned(k, 2)));
    }
    unsigned kept = 0;
    HEXRELIEF_ROLLED
    for (int part = 0; part < part_count(edges); ++part) {
        const PartCorners c = part_corners(edges, other_diagonal, part);
        if (has_area(place(c.at[0]), place(c.at[1]), place(c.at[2]))) kept |= 1u << part;
    }
    if (kept == 0) {
        edges = 0;
        kept = 1;
    }
    std::uint32_t bits = edges | static_cast<unsigned>(other_diagonal) << 3 | kept << 4 | owned << 8;
    for (int k = 0; k < 3; ++k) bits |= static_cast<unsigned>(across[k] & 3) << (12 + 2 * k);
    return {bits};
}

// The lattice's triangles by slots, two of each quad: the slot across the edge from corner k; -1: none.
HEXRELIEF_HD int slot_across(int columns, int rows, int slot, int k) {
    const int quads = columns - 1, which = slot & 1, quad = slot >> 1, row = quad / quads,
              column = quad - row * quads, odd = row & 1;
    // the other of the quad, above, below, left, right
    const bool inner = k == (which == 1 ? 2 : odd ? 0 : 1);
    if (inner) return slot ^ 1;
    if (which == 0 && k == 2) return column > 0 ? slot - 1 : -1;
    if (which == 1 && k == odd) return column + 1 < quads ? slot + 1 : -1;
    if (which == odd) return row > 0 ? 2 * (quad - quads) + odd : -1;
    return row + 2 < rows ? 2 * (quad + quads) + 1 - odd : -1;
}

}  // namespace hexrelief::step
