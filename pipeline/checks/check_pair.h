// Checks whether a pair is rectified, left and right are not exchanged, and the
// range contains its disparities.
#pragma once

#include <vector>

#include "pipeline/checks/finding.h"
#include "pipeline/stages/disparity_range.h"

namespace hexrelief::checks {

// Returns the likely mistakes in a pair; if one mistake explains several findings, only that one. Empty for a
// right pair. coarse: from match_coarsely(pair, ...), starting at range.min_px or below. A range that the
// program chose is not judged. seen_share: of the right view, as agreed_share() takes it. The result is the
// same for any number of threads.
std::vector<Finding> check_pair(const StereoPair& pair, const stages::SmallMatch& coarse,
                                const matching::DisparityRange& range, stages::RangeOrigin origin,
                                double seen_share, int threads);

}  // namespace hexrelief::checks
