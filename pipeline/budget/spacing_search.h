// The lattice spacing at which a figure of the mesh meets a limit, in as few solves as can be.
#pragma once

#include <functional>
#include <optional>

namespace hexrelief::budget {

struct SpacingSearch {
    double limit = 0;  // the figure may be at most this; > 0
    // About how fast the figure grows with the spacing, both as logarithms; its sign must be right.
    double slope = -2;
    double start_px = 6;  // tried first
    double least_px = 2;  // range of the spacing
    double most_px = 256;
};

struct SpacingFound {
    double spacing_px = 0;
    double value = 0;  // of the figure there, <= limit
    int solves = 0;    // calls of the figure, all of them
};

// The figure at a spacing (> 0), or nothing where no mesh is left at it, which counts as too coarse.
using SpacingFigure = std::function<std::optional<double>(double)>;

// A figure that falls with the spacing (slope < 0: vertices, bytes): the finest spacing found whose figure
// keeps the limit. One that grows (slope > 0: error): the coarsest. Spacings are whole hundredths of a px; at
// most 12 solves; ends when the figure comes within 3 % of the limit or the spacing is bracketed to 1 %.
// Nothing where no spacing tried keeps the limit: then `nearest` holds the one that came nearest.
std::optional<SpacingFound> search_spacing(const SpacingSearch& search, const SpacingFigure& figure,
                                           SpacingFound& nearest);

}  // namespace hexrelief::budget
