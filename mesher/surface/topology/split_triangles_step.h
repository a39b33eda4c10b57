// Cuts a triangle into parts at new vertices on its edges, and finds the neighbours of the parts.
#pragma once

#include <cstdint>

#include "mesher/common/surface_thresholds_step.h"
#include "pipeline/base/host_device.h"
#include "pipeline/data/geometry.h"
#include "pipeline/data/hex_mesh.h"

namespace hexrelief::step {

// True if the triangle's area is large enough to keep it.
HEXRELIEF_HD bool has_area(const Vec2f& a, const Vec2f& b, const Vec2f& c) {
    return (double(b.x) - a.x) * (double(c.y) - a.y) - (double(b.y) - a.y) * (double(c.x) - a.x) >
           kDegenerateArea_px;
}

// True if a share is far enough from both ends of an edge to split it there.
HEXRELIEF_HD bool splits_at(float share) {
    return share >= kLeastShare && share <= 1 - kLeastShare;
}

// Returns the number of set bits of four.
HEXRELIEF_HD int bit_count(unsigned bits) {
#ifdef __CUDA_ARCH__
    return __popc(bits);
#else
    return static_cast<int>(0x4332322132212110u >> (4 * bits) & 7u);
#endif
}

// Returns corner or edge k of a triangle, turned by `by`, 0 <= by < 3.
HEXRELIEF_HD int turned(int k, int by) {
    return k + by < 3 ? k + by : k + by - 3;
}

// Returns which of a triangle's three edges leads to a neighbour; -1: none.
template <typename Neighbours>
HEXRELIEF_HD int edge_towards(const Neighbours& neighbours, std::int32_t other) {
    HEXRELIEF_ROLLED
    for (int k = 0; k < 3; ++k)
        if (neighbours[k] == other) return k;
    return -1;
}

// Corners of a part: 0 .. 2 are the triangle's own, 3 + k is the vertex on the edge from corner k to k + 1.
struct PartCorners {
    int at[3];
};

// The cut of a triangle. The first part that has an area takes the triangle's place, the others are new
// triangles; if none has one, the triangle stays as it was.
struct Cut {
    std::uint32_t bits = 0;  // 0: the triangle is not touched

    // Bit fields: the edges with a new vertex; true if the longer diagonal separates two parts; the
    // parts that have an area; the edges whose new vertex this triangle numbers; per edge, which edge of
    // the neighbour it is.
    HEXRELIEF_HD unsigned edges() const { return bits & 7u; }
    HEXRELIEF_HD bool other_diagonal() const { return bits >> 3 & 1u; }
    HEXRELIEF_HD unsigned kept() const { return bits >> 4 & 15u; }
    HEXRELIEF_HD unsigned owned() const { return bits >> 8 & 7u; }
    HEXRELIEF_HD int edge_across(int k) const { return static_cast<int>(bits >> (12 + 2 * k) & 3u); }

    HEXRELIEF_HD int new_triangles() const { return bits == 0 ? 0 : bit_count(kept()) - 1; }
    HEXRELIEF_HD int new_points() const { return bit_count(owned()); }
    HEXRELIEF_HD bool has_part(int part) const { return kept() >> part & 1u; }
    // Returns the number of a part, if the triangle's new triangles are numbered from first_new on.
    HEXRELIEF_HD std::uint32_t number(int part, std::uint32_t triangle, std::uint32_t first_new) const {
        const int rank = bit_count(kept() & ((1u << part) - 1));
        return rank == 0 ? triangle : first_new + static_cast<std::uint32_t>(rank) - 1;
    }
    // Returns the number of the vertex on an edge, if the vertices that this triangle
    // numbers start at first_point.
    HEXRELIEF_HD std::uint32_t point(int edge, std::uint32_t first_point) const {
        return first_point + static_cast<std::uint32_t>(bit_count(owned() & ((1u << edge) - 1)));
    }
};

// Number of parts that new vertices on these edges give.
HEXRELIEF_HD int part_count(unsigned edges) {
    return 1 + bit_count(edges);
}

// Returns the corners of a part of a triangle with new vertices on `edges`.
HEXRELIEF_HD PartCorners part_corners(unsigned edges, bool other_diagonal, int part) {
    // an octal digit per corner, parts from the right, for a new vertex on edge 0, or on edges 0 and
    // 2; others are turned
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

// Returns the part that touches both corners and is not `other_than`; -1: none.
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

// Returns the triangle's edge that both corners lie on; -1 if there is none.
HEXRELIEF_HD int edge_of(int a, int b) {
    HEXRELIEF_ROLLED
    for (int k = 0; k < 3; ++k) {
        const unsigned on = 1u << k | 1u << turned(k, 1) | 1u << (3 + k);
        if ((on >> a & 1u) && (on >> b & 1u)) return k;
    }
    return -1;
}

// Converts a corner on edge k to the numbering of the neighbour across it, whose edge j it is.
HEXRELIEF_HD int corner_across(int corner, int k, int j) {
    return corner >= 3 ? 3 + j : corner == k ? turned(j, 1) : j;
}

// Returns the cut of a triangle. edges: those with a new vertex, not 0; owned, across: see Cut;
// place(corner): the position of a corner of parts.
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

// Returns the slot across the edge from corner k of a slot, -1: none. The lattice's triangles are numbered by
// slots, two per quad.
HEXRELIEF_HD int slot_across(int columns, int rows, int slot, int k) {
    const int quads = columns - 1, which = slot & 1, quad = slot >> 1, row = quad / quads,
              column = quad - row * quads, odd = row & 1;
    // in turn: the other one of the quad, left, right, above, below
    const bool inner = k == (which == 1 ? 2 : odd ? 0 : 1);
    if (inner) return slot ^ 1;
    if (which == 0 && k == 2) return column > 0 ? slot - 1 : -1;
    if (which == 1 && k == odd) return column + 1 < quads ? slot + 1 : -1;
    if (which == odd) return row > 0 ? 2 * (quad - quads) + odd : -1;
    return row + 2 < rows ? 2 * (quad + quads) + 1 - odd : -1;
}

}  // namespace hexrelief::step
