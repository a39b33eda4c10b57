// Is it a rectified pair, left and right, and does the range hold its disparities?
#pragma once

#include <vector>

#include "pipeline/checks/finding.h"
#include "pipeline/stages/disparity_range.h"

namespace hexrelief {

// What the pair seems to be wrong in; of several that have one cause only that cause. Empty for a right pair.
// coarse: match_coarsely(pair, ...) from at most range.min_px on. A range that the program chose is not
// judged. The same for any number of threads.
std::vector<Finding> check_pair(const StereoPair& pair, const SmallMatch& coarse, const DisparityRange& range,
                                RangeOrigin origin, int threads);

}  // namespace hexrelief
