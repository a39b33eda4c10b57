// Repairs the few folded triangles that training may leave: in each sweep all vertices of folded triangles
// move to the mean of their neighbours, until no triangle is folded.
#pragma once

#include "mesher/common/lattice_step.h"
#include "mesher/som/outline_step.h"
#include "pipeline/base/host_device.h"

namespace hexrelief::step {

// A triangle counts as folded if twice its signed area is not above this, px^2.
inline constexpr float kLeastArea2_px = 0.02f;
// sweeps after which the smoothed region grows by a ring of vertices
inline constexpr int kUntangleGrowth = 8;
inline constexpr int kMostUntangleSweeps = 400;
inline constexpr int kStraightenedSweep = 32;  // see smoothed_position

struct LatticeView {
    int columns, rows;
    const float* x;
    const float* y;
};

HEXRELIEF_HD float twice_area(const LatticeView& m, int a, int b, int c) {
    return (m.x[b] - m.x[a]) * (m.y[c] - m.y[a]) - (m.y[b] - m.y[a]) * (m.x[c] - m.x[a]);
}

// Returns the index of neighbour k of the vertex, or -1 if it is outside the lattice.
HEXRELIEF_HD int neighbour(const LatticeView& m, int column, int row, int k) {
    const Offset o = neighbour_offset(row, k);
    const int c = column + o.column, r = row + o.row;
    return c < 0 || c >= m.columns || r < 0 || r >= m.rows ? -1 : r * m.columns + c;
}

// True if any of the vertex's triangles is folded.
HEXRELIEF_HD bool folded(const LatticeView& m, int column, int row) {
    const int centre = row * m.columns + column;
    int previous = neighbour(m, column, row, 5);
    HEXRELIEF_ROLLED
    for (int k = 0; k < 6; ++k) {
        const int next = neighbour(m, column, row, k);
        if (previous >= 0 && next >= 0 && !(twice_area(m, centre, previous, next) > kLeastArea2_px))
            return true;
        previous = next;
    }
    return false;
}

// The constraints on the lattice's border during the repair.
struct BorderHold {
    bool pinned;  // to the area's border; else it moves freely
    Outline outline;
};

// Returns the new position of a smoothed vertex: the mean of its six neighbours, or on the lattice's border
// the mean of the two along it. Corners stay. (The mean of all neighbours of a border vertex would draw the
// border inwards without end: 400 sweeps did not unfold a corner of a 214 x 185 lattice.) If the border is
// pinned, only the coordinate along it changes. A straight border is convex, so the repair always succeeds. A
// bent one is not convex; therefore, from kStraightenedSweep on, y is averaged as its share of the way from
// the upper to the lower border, in which both borders are straight.
HEXRELIEF_HD Position smoothed_position(const LatticeView& m, const BorderHold& border, int sweep, int column,
                                        int row) {
    const bool side = column == 0 || column == m.columns - 1, end = row == 0 || row == m.rows - 1;
    const int at = row * m.columns + column;
    float x = m.x[at], y = m.y[at];
    if (side && end) return {x, y};
    if (side || end) {
        const int stride = side ? m.columns : 1;
        if (!(border.pinned && side)) x = (m.x[at - stride] + m.x[at + stride]) * 0.5f;
        if (!(border.pinned && end))
            y = (m.y[at - stride] + m.y[at + stride]) * 0.5f;
        else if (is_bent(border.outline))
            y = curve_at(border.outline, curve_of(border.outline, row), x);
        return {x, y};
    }
    const bool shares = is_bent(border.outline) && sweep >= kStraightenedSweep;
    float sx = 0, sy = 0;
    HEXRELIEF_ROLLED
    for (int k = 0; k < 6; ++k) {
        const int i = neighbour(m, column, row, k);
        sx += m.x[i];
        sy += shares ? share_of(border.outline, m.x[i], m.y[i]) : m.y[i];
    }
    x = sx / 6.0f;
    return {x, shares ? y_of_share(border.outline, x, sy / 6.0f) : sy / 6.0f};
}

}  // namespace hexrelief::step
