// Repairs the few folded triangles that a stochastic map can leave: vertices of folded triangles go to the mean of
// their neighbours, all at once, until nothing is folded.
#pragma once

#include <cstddef>

#include "mesher/steps/host_device.h"
#include "mesher/steps/lattice.h"

namespace hexrelief::step {

inline constexpr float kLeastArea2_px = 0.02f;  // twice a triangle's signed area below which it counts as folded
inline constexpr int kUntangleGrowth = 8;       // sweeps after which the smoothed region grows by a ring
inline constexpr int kMostUntangleSweeps = 400;

struct LatticeView {
    int columns, rows;
    const float* x;
    const float* y;
};

HEXRELIEF_HD float twice_area(const LatticeView& m, int a, int b, int c) {
    return (m.x[b] - m.x[a]) * (m.y[c] - m.y[a]) - (m.y[b] - m.y[a]) * (m.x[c] - m.x[a]);
}

// Index of neighbour k of the vertex, or -1 outside the lattice.
HEXRELIEF_HD int neighbour(const LatticeView& m, int column, int row, int k) {
    const Offset o = neighbour_offset(row, k);
    const int c = column + o.column, r = row + o.row;
    return c < 0 || c >= m.columns || r < 0 || r >= m.rows ? -1 : r * m.columns + c;
}

// Whether any of the vertex's triangles is folded.
HEXRELIEF_HD bool folded(const LatticeView& m, int column, int row) {
    const int centre = row * m.columns + column;
    int previous = neighbour(m, column, row, 5);
    for (int k = 0; k < 6; ++k) {
        const int next = neighbour(m, column, row, k);
        if (previous >= 0 && next >= 0 && !(twice_area(m, centre, previous, next) > kLeastArea2_px)) return true;
        previous = next;
    }
    return false;
}

// Mean of the existing neighbours, summed in their order.
HEXRELIEF_HD void neighbour_mean(const LatticeView& m, int column, int row, float& x, float& y) {
    float sx = 0, sy = 0, n = 0;
    for (int k = 0; k < 6; ++k) {
        const int i = neighbour(m, column, row, k);
        if (i < 0) continue;
        sx += m.x[i];
        sy += m.y[i];
        n += 1;
    }
    x = sx / n;
    y = sy / n;
}

}  // namespace hexrelief::step
