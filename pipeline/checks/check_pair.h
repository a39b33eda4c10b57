// Checks whether a pair is rectified, left and right are not exchanged, and the
// range contains its disparities.
#pragma once

#include <vector>

#include "pipeline/checks/finding.h"
#include "pipeline/stages/disparity_range.h"

namespace hexrelief::checks {

enum class RangeOrigin { chosen, given, ndisp };

struct SearchedRange {
    int min_px = 0, count_px = 0;
    RangeOrigin origin = RangeOrigin::chosen;  // a range that the program chose is not judged
};

// Returns what seems to be wrong with a pair; empty if nothing is. If several findings have one cause, only
// the cause is returned. coarse: the result of match_coarsely(pair, ...) from at most range.min_px on. The
// result is the same for any number of threads.
std::vector<Finding> check_pair(const StereoPair& pair, const stages::SmallMatch& coarse,
                                const SearchedRange& range, int threads);

}  // namespace hexrelief::checks
