// Topology of the hexagonal lattice. Vertices are numbered row by row, odd rows are shifted right by half a
// spacing, and the axial coordinates are q = column - (row - (row & 1)) / 2, r = row.
#pragma once

#include "pipeline/base/host_device.h"

namespace hexrelief::step {

struct Lattice {
    int columns, rows;
};

// A point of the image, px.
struct Position {
    float x, y;
};

// The axial coordinate q of a vertex.
HEXRELIEF_HD int axial_q(int column, int row) {
    return column - (row - (row & 1)) / 2;
}

// The absolute value, callable on the device.
HEXRELIEF_HD int abs_of(int v) {
    return v < 0 ? -v : v;
}

// The vertices of one row within `radius` lattice steps of a given vertex: `length` columns from `first` on,
// which may reach beyond the lattice; `row_distance` is the number of rows between the two.
struct RowSpan {
    int first, length, row_distance;
};

// Returns the span of `other_row` around vertex (column, row). |row - other_row| must be <= radius.
HEXRELIEF_HD RowSpan row_span(int column, int row, int radius, int other_row) {
    const int dr = other_row - row;
    const int lowest_q = dr < 0 ? -radius - dr : -radius;
    return {axial_q(column, row) + lowest_q + (other_row - (other_row & 1)) / 2, 2 * radius + 1 - abs_of(dr),
            abs_of(dr)};
}

// Distance in lattice steps from the given vertex to vertex i of the span, 0 <= i < length (d_G of
// the paper, section 3).
HEXRELIEF_HD int span_distance(const RowSpan& span, int radius, int i) {
    return radius - min_of(min_of(i, span.length - 1 - i), radius - span.row_distance);
}

// Column and row of a neighbour relative to a vertex.
struct Offset {
    int column, row;
};

// Returns the offset of neighbour k, 0..5, of a vertex in `row`: counter-clockwise as seen with y up, from
// the eastern neighbour on and then by rising row.
HEXRELIEF_HD Offset neighbour_offset(int row, int k) {
    // one hexadecimal digit per neighbour, k = 0 rightmost: column offset + 1 in even rows, what odd rows add
    // to it, and row offset + 1
    const unsigned even = 0x100012u, odd = 0x110110u, rows = 0x001221u;
    const auto digit = [k](unsigned table) { return static_cast<int>(table >> (4 * k) & 15u); };
    return {digit(even) + digit(odd) * (row & 1) - 1, digit(rows) - 1};
}

}  // namespace hexrelief::step
