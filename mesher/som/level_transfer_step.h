// From one level to the next: coarser densities, and the start positions of a finer lattice. Each level is a
// self-organizing map of its own; the density of level n is halved in size n times.
#pragma once

#include <cstddef>

#include "mesher/common/lattice_step.h"
#include "pipeline/base/host_device.h"

namespace hexrelief::step {

// Position of a lattice vertex in an undeformed lattice over an image of width x height px.
HEXRELIEF_HD float regular_x(int column, int row, int columns, float width) {
    return (static_cast<float>(column) + 0.25f + 0.5f * static_cast<float>(row & 1)) * width /
           static_cast<float>(columns);
}
HEXRELIEF_HD float regular_y(int row, int rows, float height) {
    return (static_cast<float>(row) + 0.5f) * height / static_cast<float>(rows);
}

// Returns a pixel of the next coarser density: the sum of the up to four pixels that it covers,
// in a fixed order.
HEXRELIEF_HD float coarser_pixel(const float* fine, int fine_width, int fine_height, int x, int y) {
    const int x0 = 2 * x, y0 = 2 * y;
    const bool right = x0 + 1 < fine_width, below = y0 + 1 < fine_height;
    const float* const row = fine + static_cast<std::size_t>(y0) * fine_width;
    const float upper = row[x0] + (right ? row[x0 + 1] : 0.0f);
    if (!below) return upper;
    return upper + (row[fine_width + x0] + (right ? row[fine_width + x0 + 1] : 0.0f));
}

// Returns the coordinate u of a vertex along its row, in lattice steps, with the shift of odd rows. If the
// border is pinned, the ends of all rows lie on it: u is 0 and columns - 1/2 there.
HEXRELIEF_HD float column_u(const Lattice& lattice, int column, int row, bool pinned) {
    if (pinned && column == 0) return 0.0f;
    if (pinned && column == lattice.columns - 1) return static_cast<float>(lattice.columns) - 0.5f;
    return static_cast<float>(column) + 0.5f * static_cast<float>(row & 1);
}

// Interpolates vertex coordinates linearly along one row at u, and extrapolates beyond a free border.
// values[i] belongs to vertex i.
template <typename Values>
HEXRELIEF_HD float along_row(const Values& values, const Lattice& lattice, int row, float u, bool pinned) {
    const int c0 =
        // int(u + 1) - 1 rounds down, as u > -1
        clamp_to(static_cast<int>(u - 0.5f * static_cast<float>(row & 1) + 1.0f) - 1, 0, lattice.columns - 2);
    const float from = column_u(lattice, c0, row, pinned), to = column_u(lattice, c0 + 1, row, pinned);
    const float f = (u - from) / (to - from);
    const std::size_t at = static_cast<std::size_t>(row) * lattice.columns + c0;
    return values[at] * (1.0f - f) + values[at + 1] * f;
}

// A lattice and the next finer one. Pinned lattices cover the same area; free ones were laid
// over the same image.
struct Refinement {
    Lattice from, to;
    bool pinned;
};

// Returns one coordinate of a vertex of the finer lattice in the coarser level's px, interpolated between the
// coarser lattice's vertices; coarse[i] belongs to its vertex i.
template <typename Values>
HEXRELIEF_HD float interpolated(const Values& coarse, const Refinement& refinement, int column, int row) {
    const Lattice &from = refinement.from, &to = refinement.to;
    const bool pinned = refinement.pinned;
    const float columns = static_cast<float>(from.columns), to_columns = static_cast<float>(to.columns);
    const float rows = static_cast<float>(from.rows), to_rows = static_cast<float>(to.rows);
    const float at = column_u(to, column, row, pinned);
    const float u =
        pinned ? at * (columns - 0.5f) / (to_columns - 0.5f) : (at + 0.25f) * columns / to_columns - 0.25f;
    const float v = pinned ? static_cast<float>(row) * (rows - 1.0f) / (to_rows - 1.0f)
                           : (static_cast<float>(row) + 0.5f) * rows / to_rows - 0.5f;
    // int(v + 1) - 1 rounds down, as v > -1
    const int r0 = clamp_to(static_cast<int>(v + 1.0f) - 1, 0, from.rows - 2);
    const float f = v - static_cast<float>(r0);
    return along_row(coarse, from, r0, u, pinned) * (1.0f - f) +
           along_row(coarse, from, r0 + 1, u, pinned) * f;
}

// Returns the same coordinate in the finer level's px, within [0, extent], the finer image's
// size in that direction.
HEXRELIEF_HD float prolongate(const float* coarse, const Refinement& refinement, int column, int row,
                              float extent) {
    return clamp_to(interpolated(coarse, refinement, column, row) * 2.0f, 0.0f, extent);
}

// Returns the sampling weight density^magnification by linear interpolation in a table of `steps` + 1
// entries. `share` is the density over the largest one, 0..1.
HEXRELIEF_HD float magnify(float share, const float* table, int steps) {
    const float at = share * static_cast<float>(steps);
    const int i = clamp_to(static_cast<int>(at), 0, steps - 1);
    const float f = at - static_cast<float>(i);
    return table[i] * (1.0f - f) + table[i + 1] * f;
}

}  // namespace hexrelief::step
