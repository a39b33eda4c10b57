// Do a map and a picture show one view?
#pragma once

#include "pipeline/data/disparity_map.h"

namespace hexrelief::checks {

// The picture's contrast across the map's steps along one axis, in units of the contrast around them.
struct AxisFit {
    int steps = 0;        // pixels at depth discontinuities, along the lines looked at
    double here = 0;      // at the steps, within a pixel
    double farthest = 0;  // here's distance from the contrast elsewhere, in its standard deviations there
    double best = 0;      // where it is largest, within the reach of the search
    int best_px = 0;      // how far right or down of the steps that is
};

struct EdgeFit {
    AxisFit columns, rows;  // steps from one column to the next, from one row to the next
};

// Both have one size.
EdgeFit measure_edge_fit(const DisparityMap& map, const Image& left);

}  // namespace hexrelief::checks
