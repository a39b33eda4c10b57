// Measures whether a map and a picture show the same view.
#pragma once

#include "pipeline/data/disparity_map.h"

namespace hexrelief::checks {

// The picture's contrast across the map's steps along one axis, relative to the contrast around them.
struct AxisFit {
    int steps = 0;    // number of pixels at depth discontinuities, along the lines examined
    double here = 0;  // contrast at the steps, within a pixel
    // Difference of `here` from the contrast elsewhere, in standard deviations of the latter.
    double farthest = 0;
    double best = 0;  // largest contrast within the reach of the search
    int best_px = 0;  // offset of the largest contrast, to the right of or below the steps
};

struct EdgeFit {
    AxisFit columns, rows;  // steps from one column to the next, and from one row to the next
};

// Measures both axes. The map and the picture have one size.
EdgeFit measure_edge_fit(const DisparityMap& map, const Image& left);

}  // namespace hexrelief::checks
