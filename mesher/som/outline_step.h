// Where the lattice's upper and lower border lie: on those of its area, or bent into deep empty valleys of
// the density, so that no cells are left over for them.
#pragma once

#include "mesher/common/lattice_step.h"

namespace hexrelief::step {

// Both borders as curves over the area's columns, in px of the finest level, which all levels read.
struct Outline {
    const float* upper = nullptr;  // y at x = 0, 1, .. width; none: straight
    const float* lower = nullptr;
    int width = 0;
    float finest = 1, level = 1;  // px of the finest level in one of this level, and the other way round
};

HEXRELIEF_HD bool is_bent(const Outline& o) {
    return o.upper != nullptr;
}

// y of a curve at x, both in px of the level.
HEXRELIEF_HD float curve_at(const Outline& o, const float* curve, float x) {
    const float at = clamp_to(x * o.finest, 0.0f, static_cast<float>(o.width));
    const int i = clamp_to(static_cast<int>(at), 0, o.width - 1);
    return (curve[i] + (at - static_cast<float>(i)) * (curve[i + 1] - curve[i])) * o.level;
}

// dy / dx there, over one px.
HEXRELIEF_HD float curve_slope(const Outline& o, const float* curve, float x) {
    return curve_at(o, curve, x + 0.5f) - curve_at(o, curve, x - 0.5f);
}

// The curve of the first row, else that of the last.
HEXRELIEF_HD const float* curve_of(const Outline& o, int row) {
    return row == 0 ? o.upper : o.lower;
}

// y as a share of the way from border to border, and back.
HEXRELIEF_HD float share_of(const Outline& o, float x, float y) {
    const float upper = curve_at(o, o.upper, x);
    return (y - upper) / (curve_at(o, o.lower, x) - upper);
}
HEXRELIEF_HD float y_of_share(const Outline& o, float x, float share) {
    const float upper = curve_at(o, o.upper, x);
    return upper + share * (curve_at(o, o.lower, x) - upper);
}

HEXRELIEF_HD bool is_side(const Lattice& lattice, int column) {
    return column == 0 || column == lattice.columns - 1;
}
HEXRELIEF_HD bool is_end(const Lattice& lattice, int row) {
    return row == 0 || row == lattice.rows - 1;
}

// Puts a vertex of the lattice's border onto that of an area of width x height px; others stay.
HEXRELIEF_HD void pin_to_border(const Lattice& lattice, const Outline& outline, int column, int row,
                                float width, float height, float& x, float& y) {
    if (column == 0) x = 0.0f;
    if (column == lattice.columns - 1) x = width;
    if (!is_end(lattice, row)) return;
    if (is_bent(outline))
        y = curve_at(outline, curve_of(outline, row), x);
    else
        y = row == 0 ? 0.0f : height;
}

// Whether a vertex rests while others learn: those of the sides, where a bent border lets the density lie
// beyond their end, would all run there.
HEXRELIEF_HD bool rests(const Lattice& lattice, const Outline& outline, int column) {
    return is_bent(outline) && is_side(lattice, column);
}

// How far an edge between two vertices of one end, `from` the left one, cuts into what lies within the curve,
// px of the finest level, which theirs must be.
HEXRELIEF_HD float cut_off(const Outline& o, int row, float from_x, float from_y, float to_x, float to_y) {
    if (!(to_x > from_x)) return 0.0f;
    const float* const curve = curve_of(o, row);
    const float slope = (to_y - from_y) / (to_x - from_x);
    const int last = clamp_to(static_cast<int>(to_x), 0, o.width);
    float most = 0;
    for (int x = clamp_to(static_cast<int>(from_x) + 1, 0, o.width); x <= last; ++x) {
        const float inside = from_y + (static_cast<float>(x) - from_x) * slope - curve[x];
        most = max_of(most, row == 0 ? inside : -inside);
    }
    return most;
}

}  // namespace hexrelief::step
