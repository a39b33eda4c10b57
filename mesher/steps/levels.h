// Coarse to fine: each level is a self-organizing map of its own, on a density halved in size as often as its
// number says.
#pragma once

#include <cstddef>

#include "mesher/steps/host_device.h"
#include "mesher/steps/lattice.h"

namespace hexrelief::step {

// Undeformed position of a lattice vertex in an image of width x height px.
HEXRELIEF_HD float regular_x(int column, int row, int columns, float width) {
    return (static_cast<float>(column) + 0.25f + 0.5f * static_cast<float>(row & 1)) * width /
           static_cast<float>(columns);
}
HEXRELIEF_HD float regular_y(int row, int rows, float height) {
    return (static_cast<float>(row) + 0.5f) * height / static_cast<float>(rows);
}

// Pixel of the next coarser density: the sum of the (up to) four that it covers, in a fixed order.
HEXRELIEF_HD float coarser_pixel(const float* fine, int fine_width, int fine_height, int x, int y) {
    const int x0 = 2 * x, y0 = 2 * y;
    const bool right = x0 + 1 < fine_width, below = y0 + 1 < fine_height;
    const float* const row = fine + static_cast<std::size_t>(y0) * fine_width;
    const float upper = row[x0] + (right ? row[x0 + 1] : 0.0f);
    if (!below) return upper;
    return upper + (row[fine_width + x0] + (right ? row[fine_width + x0 + 1] : 0.0f));
}

// Coarse lattice coordinate along one row, linearly inter- and extrapolated. u: position in columns,
// half-cell shift included.
HEXRELIEF_HD float along_row(const float* values, const Lattice& lattice, int row, float u) {
    const float c = u - 0.25f - 0.5f * static_cast<float>(row & 1);
    const int c0 = clamp_to(static_cast<int>(c + 1.0f) - 1, 0, lattice.columns - 2);
    const float f = c - static_cast<float>(c0);
    const float* const v = values + static_cast<std::size_t>(row) * lattice.columns + c0;
    return v[0] * (1.0f - f) + v[1] * f;
}

// One coordinate of a vertex of the finer lattice, in the finer level's px, from the coarser lattice's
// positions. extent is the finer image's size in that direction.
HEXRELIEF_HD float prolongate(const float* coarse, const Lattice& from, const Lattice& to, int column,
                              int row, float extent) {
    const float v =
        (static_cast<float>(row) + 0.5f) * static_cast<float>(from.rows) / static_cast<float>(to.rows) - 0.5f;
    const float u = (static_cast<float>(column) + 0.25f + 0.5f * static_cast<float>(row & 1)) *
                    static_cast<float>(from.columns) / static_cast<float>(to.columns);
    const int r0 = clamp_to(static_cast<int>(v + 1.0f) - 1, 0, from.rows - 2);
    const float f = v - static_cast<float>(r0);
    const float value = along_row(coarse, from, r0, u) * (1.0f - f) + along_row(coarse, from, r0 + 1, u) * f;
    return clamp_to(value * 2.0f, 0.0f, extent);
}

// Sampling weight density^magnification from a table over [0, 1] with `steps` + 1 entries, linearly
// interpolated.
HEXRELIEF_HD float magnify(float share, const float* table, int steps) {
    const float at = share * static_cast<float>(steps);
    const int i = clamp_to(static_cast<int>(at), 0, steps - 1);
    const float f = at - static_cast<float>(i);
    return table[i] * (1.0f - f) + table[i + 1] * f;
}

}  // namespace hexrelief::step
