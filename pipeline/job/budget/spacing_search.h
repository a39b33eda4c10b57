// Finds the lattice spacing at which a figure of the mesh meets a limit, in as few solves as possible.
#pragma once

#include <functional>
#include <optional>

namespace hexrelief::job {

struct SpacingSearch {
    double limit = 0;  // upper limit of the figure; > 0
    // Rough slope of the figure over the spacing, both as logarithms; its sign must be right.
    double slope = -2;
    double start_px = 6;  // tried first
    double least_px = 2;  // range of the spacing
    double most_px = 256;
};

struct SpacingFound {
    double spacing_px = 0;
    double value = 0;  // the figure at this spacing, <= limit
    int solves = 0;    // all calls of the figure
};

// Returns the figure at a spacing (> 0), or nothing if no mesh is left, which counts as too coarse.
using SpacingFigure = std::function<std::optional<double>(double)>;

// Finds the best spacing whose figure keeps the limit: the finest one if the figure falls with the
// spacing (slope < 0: vertices, bytes), the coarsest if it grows (slope > 0: error). Spacings are
// multiples of 0.01 px. The search ends after 12 solves, or when the figure is within 3 % of the limit or
// the spacing is bracketed to 1 %. Returns nothing if no spacing tried keeps the limit; `nearest` then
// holds the one that came nearest.
std::optional<SpacingFound> search_spacing(const SpacingSearch& search, const SpacingFigure& figure,
                                           SpacingFound& nearest);

}  // namespace hexrelief::job
