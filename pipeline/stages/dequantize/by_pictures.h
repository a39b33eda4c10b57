// Refines a matched map by its pictures, and by the smoothest surface where they tell nothing.
#pragma once

#include "pipeline/data/disparity_map.h"

namespace hexrelief::stages {

// Moves the disparities of a matched map to where the right picture's levels fit best (Lucas & Kanade 1981)
// and the surface bends least. How much a pixel's levels count follows from how steep they are and how well
// the pictures agree, so a bare wall becomes the surface through what is beside it. How much surfaces bend
// follows from the map, and from how well the pictures still fit. pair: the pictures that the map was
// matched from, of at least 4 columns. Discontinuities (neighbours more than 1 px apart) stay, except
// short ones, and those between pixels whose levels tell no disparity. Unknown pixels stay unknown, and no
// disparity leaves the map's range. The result is the same for any number of threads (>= 1).
DisparityMap refine_by_pictures(const DisparityMap& map, const StereoPair& pair, int threads);

}  // namespace hexrelief::stages
