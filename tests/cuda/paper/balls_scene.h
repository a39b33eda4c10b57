// A synthetic scene of any size for `bench_paper`.
#pragma once

#include "pipeline/data/disparity_map.h"

namespace hexrelief::paper {

// Returns disparities of 6 to 64 px: a floor that comes nearer downwards, a far wall, two dozen balls, and an
// unknown strip on the left, as in a matched pair. The scene is the same at every size, the values are the
// same on every machine. Precondition: both sides >= 1.
DisparityMap made_up_scene(int width, int height);

}  // namespace hexrelief::paper
