// The upper and lower border of the lattice: straight, on the area's border, or bent into deep empty valleys
// of the density, which then need no cells.
#pragma once

#include "mesher/common/lattice_step.h"

namespace hexrelief::step {

// Both borders as curves over the area's columns, in px of the finest level; all levels read the same curves.
struct Outline {
    const float* upper = nullptr;  // y at x = 0, 1, .. width; null: both borders are straight
    const float* lower = nullptr;
    int width = 0;
    float finest = 1, level = 1;  // px of the finest level per px of this level, and the inverse
};

// True if the borders are curves, false if they are straight.
HEXRELIEF_HD bool is_bent(const Outline& o) {
    return o.upper != nullptr;
}

// Returns y of a curve at x, both in px of the level.
HEXRELIEF_HD float curve_at(const Outline& o, const float* curve, float x) {
    const float at = clamp_to(x * o.finest, 0.0f, static_cast<float>(o.width));
    const int i = clamp_to(static_cast<int>(at), 0, o.width - 1);
    return (curve[i] + (at - static_cast<float>(i)) * (curve[i + 1] - curve[i])) * o.level;
}

// Returns the slope dy / dx of a curve at x, measured over one px.
HEXRELIEF_HD float curve_slope(const Outline& o, const float* curve, float x) {
    return curve_at(o, curve, x + 0.5f) - curve_at(o, curve, x - 0.5f);
}

// Returns the curve of the first row or, for any other row, that of the last.
HEXRELIEF_HD const float* curve_of(const Outline& o, int row) {
    return row == 0 ? o.upper : o.lower;
}

// Converts y to the share of the way from the upper to the lower border at x. y_of_share() is the inverse.
HEXRELIEF_HD float share_of(const Outline& o, float x, float y) {
    const float upper = curve_at(o, o.upper, x);
    return (y - upper) / (curve_at(o, o.lower, x) - upper);
}
// Converts such a share back to y.
HEXRELIEF_HD float y_of_share(const Outline& o, float x, float share) {
    const float upper = curve_at(o, o.upper, x);
    return upper + share * (curve_at(o, o.lower, x) - upper);
}

// True if a column is the first or last of the lattice.
HEXRELIEF_HD bool is_side(const Lattice& lattice, int column) {
    return column == 0 || column == lattice.columns - 1;
}
// True if a row is the first or last of the lattice.
HEXRELIEF_HD bool is_end(const Lattice& lattice, int row) {
    return row == 0 || row == lattice.rows - 1;
}

// The border of a level's area of width x height px, to which the lattice's border is pinned.
struct Border {
    Lattice lattice;
    Outline outline;
    float width, height;
};

// Moves a vertex of the lattice's border onto the area's border; other vertices stay.
HEXRELIEF_HD void pin_to_border(const Border& border, int column, int row, float& x, float& y) {
    if (column == 0) x = 0.0f;
    if (column == border.lattice.columns - 1) x = border.width;
    if (!is_end(border.lattice, row)) return;
    if (is_bent(border.outline))
        y = curve_at(border.outline, curve_of(border.outline, row), x);
    else
        y = row == 0 ? 0.0f : border.height;
}

// True if a vertex stays in place while others learn: the vertices of the left and right side, if the borders
// are bent. Density may lie beyond the ends of a bent border, and these vertices would all gather there.
HEXRELIEF_HD bool rests(const Border& border, int column) {
    return is_bent(border.outline) && is_side(border.lattice, column);
}

// Returns the largest depth, in px, by which the edge between two neighbouring vertices of the first or last
// row cuts into the region between the curves. `from` is the left vertex; both are in px of the finest level.
HEXRELIEF_HD float cut_off(const Outline& o, int row, const Position& from, const Position& to) {
    if (!(to.x > from.x)) return 0.0f;
    const float* const curve = curve_of(o, row);
    const float slope = (to.y - from.y) / (to.x - from.x);
    const int last = clamp_to(static_cast<int>(to.x), 0, o.width);
    float most = 0;
    for (int x = clamp_to(static_cast<int>(from.x) + 1, 0, o.width); x <= last; ++x) {
        const float inside = from.y + (static_cast<float>(x) - from.x) * slope - curve[x];
        most = max_of(most, row == 0 ? inside : -inside);
    }
    return most;
}

}  // namespace hexrelief::step
