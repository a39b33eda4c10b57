// Is it a rectified pair, left and right, and does the range hold its disparities?
#pragma once

#include <vector>

#include "pipeline/checks/finding.h"
#include "pipeline/stages/disparity_range.h"

namespace hexrelief::checks {

enum class RangeOrigin { chosen, given, ndisp };

struct SearchedRange {
    int min_px = 0, count_px = 0;
    RangeOrigin origin = RangeOrigin::chosen;  // one that the program chose is not judged
};

// What the pair seems to be wrong in; of several that have one cause only that cause. Empty for a right pair.
// coarse: match_coarsely(pair, ...) from at most range.min_px on. The same for any number of threads.
std::vector<Finding> check_pair(const StereoPair& pair, const stages::SmallMatch& coarse,
                                const SearchedRange& range, int threads);

}  // namespace hexrelief::checks
