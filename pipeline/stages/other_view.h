// What the right camera sees that the left one does not.
#pragma once

#include <vector>

#include "pipeline/data/disparity_map.h"

namespace hexrelief::stages {

// Disparities of the pixels of the right view that the left camera does not see, row-major; 0 at all others.
// The left map (px; not above 0 = unknown) is warped to x - d, nearer surfaces in front; neighbours at most 1
// px apart in disparity are joined. A gap of 2 px or more between two seen pixels of a row is hidden from the
// left camera: there the farther of the two surfaces at its ends goes on. Left out are gaps where the left
// map does not know all pixels between these ends, and pixels that would lie outside the left image.
std::vector<float> hidden_from_left(const DisparityMap& left, int threads);

}  // namespace hexrelief::stages
