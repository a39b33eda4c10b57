// A made-up scene of any size for `hexrelief bench cuda`.
#pragma once

#include "pipeline/data/disparity_map.h"

namespace hexrelief::bench {

// Disparities of 6 to 64 px: a floor that comes nearer downwards, a far wall, two dozen balls, a strip at the
// left that is unknown as in a matched pair. The same scene at every size, the same values on every machine.
// Precondition: both sides >= 1.
DisparityMap made_up_scene(int width, int height);

}  // namespace hexrelief::bench
