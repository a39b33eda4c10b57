// Checks whether a pair is rectified, left and right are not exchanged, and the
// range contains its disparities.
#pragma once

#include <vector>

#include "pipeline/checks/finding.h"
#include "pipeline/stages/disparity_range.h"

namespace hexrelief::checks {

// What the pair seems to be wrong in; of several that have one cause only that cause. Empty for a right pair.
// coarse: match_coarsely(pair, ...) from at most range.min_px on. A range that the program chose is not
// judged. The same for any number of threads.
std::vector<Finding> check_pair(const StereoPair& pair, const stages::SmallMatch& coarse,
                                const matching::DisparityRange& range, stages::RangeOrigin origin,
                                int threads);

}  // namespace hexrelief::checks
