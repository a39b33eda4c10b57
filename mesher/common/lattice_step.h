// Topology of the hexagonal lattice: row-major, odd rows shifted right by half a spacing, axial coordinates
// q = column - (row - (row & 1)) / 2, r = row.
#pragma once

#include "mesher/common/host_device.h"

namespace hexrelief::step {

struct Lattice {
    int columns, rows;
};

// px
struct Position {
    float x, y;
};

HEXRELIEF_HD int axial_q(int column, int row) {
    return column - (row - (row & 1)) / 2;
}

HEXRELIEF_HD int abs_of(int v) {
    return v < 0 ? -v : v;
}

// The part of a row within `radius` lattice steps of a vertex: `length` columns from `first` on, which may
// reach beyond the lattice. Its i-th vertex is min(i, length - 1 - i, radius - row_distance) steps nearer
// than `radius` (d_G of the paper, section 3).
struct RowSpan {
    int first, length, row_distance;
};

HEXRELIEF_HD RowSpan row_span(int column, int row, int radius, int other_row) {
    const int dr = other_row - row;
    const int lowest_q = dr < 0 ? -radius - dr : -radius;
    return {axial_q(column, row) + lowest_q + (other_row - (other_row & 1)) / 2, 2 * radius + 1 - abs_of(dr),
            abs_of(dr)};
}

HEXRELIEF_HD int span_distance(const RowSpan& span, int radius, int i) {
    return radius - min_of(min_of(i, span.length - 1 - i), radius - span.row_distance);
}

// The six neighbours in counter-clockwise order as seen with y up (east first, then by rising row): offsets
// of neighbour k.
struct Offset {
    int column, row;
};

HEXRELIEF_HD Offset neighbour_offset(int row, int k) {
    // a digit each, from k = 0 at the right: column + 1 in even rows, what odd ones add, row + 1
    const unsigned even = 0x100012u, odd = 0x110110u, rows = 0x001221u;
    const auto digit = [k](unsigned table) { return static_cast<int>(table >> (4 * k) & 15u); };
    return {digit(even) + digit(odd) * (row & 1) - 1, digit(rows) - 1};
}

}  // namespace hexrelief::step
