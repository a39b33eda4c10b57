// Gives near surfaces the parts of them that were filled from what lies behind.
#pragma once

#include "pipeline/data/disparity_map.h"
#include "pipeline/data/image.h"

namespace hexrelief::stages {

// What the right camera does not see beside a near thing is filled from behind that thing; so is a bare part
// of the thing itself along its rim, if nothing of it matches. Here the filled pixels within 1/60 of the
// longer side of a step (of disparity: more than 1/225 of the longer side, and 2 px) go to the nearer surface
// if the least steps of colour lead to them from there. A region of these goes if it has at least as many
// pixels as the width, if more than half of its border to the nearer surface is open (of one colour across
// it), and more than half of its other borders are contours. It takes the disparities beside it, smoothed.
// left: the picture of the map's view and size; without one, or without origins, nothing moves. Origins
// stay. The same for any number of threads.
DisparityMap with_filled_rims_joined(DisparityMap map, const Image& left, int threads);

}  // namespace hexrelief::stages
