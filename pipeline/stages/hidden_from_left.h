// The surfaces that the right camera sees and the left one does not.
#pragma once

#include <vector>

#include "pipeline/data/disparity_map.h"

namespace hexrelief::stages {

// Returns, row-major, the disparities of those pixels of the right view that the left camera does not see; 0
// at all other pixels. The left map (px; values not above 0 = unknown) is warped to x - d, nearer surfaces in
// front; neighbours whose disparities differ by at most 1 px are joined. A gap of 2 px or more between two
// visible pixels of a row is hidden from the left camera; the farther one of the two surfaces at its ends is
// continued there. Two kinds of gaps stay 0: those between whose ends the left map has unknown pixels, and
// pixels that would lie outside the left image.
std::vector<float> hidden_from_left(const DisparityMap& left, int threads);

}  // namespace hexrelief::stages
