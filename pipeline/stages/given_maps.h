// Decides between the disparities that another matcher gave and those that they were refined to.
#pragma once

#include "pipeline/data/disparity_map.h"

namespace hexrelief::stages {

// The disparities of both views, each at its own columns.
struct ViewMaps {
    DisparityMap left, right;
    // True if the matcher gave a disparity to nearly every pixel, as networks do. Pixels of low confidence
    // are unknown in the maps nevertheless.
    bool is_dense = false;
};

// Returns the left view's map: the given disparities where the refined ones are not better. refined: of the
// same size, with origins. If the right picture's colours say that the given discontinuities are at the wrong
// place, which is the case if more than 4 % of the pixels beside discontinuities look more like those that
// the refined disparities match, the refined disparities count near them, and where the right view
// contradicts the given ones; else only where both the right view and the colours contradict. What the right
// camera does not see stays as given. The right view contradicts if it sees something farther there. Known
// disparities are at least `least_px`.
DisparityMap keep_given(const StereoPair& pair, const ViewMaps& given, DisparityMap refined, float least_px);

}  // namespace hexrelief::stages
