// Measures whether a map and a picture show the same view.
#pragma once

#include <optional>

#include "pipeline/data/disparity_map.h"

namespace hexrelief::checks {

// How well the picture's edges along one axis lie at the map's depth discontinuities. Fits are counted in
// standard deviations above the mean of those that the picture has if it is moved far away, so a picture of
// anything else fits by about 0 with its own texture, however strong.
struct AxisFit {
    int steps = 0;    // depth discontinuities, along the lines examined
    double here = 0;  // fit within 2 px
    double best = 0;  // largest fit within the reach of the search
    int best_px = 0;  // its offset, to the right of or below the steps
};

struct EdgeFit {
    AxisFit columns, rows;  // steps from left to right, and from top to bottom
};

// Measures both axes. The map and the picture have one size. Edges of the map may be wide, and its surfaces
// may be larger or smaller than those of the picture by some px, as matchers and networks leave them: that
// moves both sides of a thing against each other, and a shift moves them alike.
EdgeFit measure_edge_fit(const DisparityMap& map, const Image& left);

// Returns the fit of both axes together, in standard deviations; nullopt if neither has enough steps.
std::optional<double> fit_of(const EdgeFit& fit);

}  // namespace hexrelief::checks
