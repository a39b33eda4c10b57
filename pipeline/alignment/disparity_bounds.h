// Which disparities a pair has, and where infinity is.
#pragma once

#include "pipeline/alignment/alignment.h"

namespace hexrelief::alignment {

// Returns the bounds of the estimate's views, in px of the pictures as given. scale: px of the matches'
// pictures per px of those.
DisparityBounds bounds_of(const Estimate& estimate, bool is_focal_known, double scale);

// Returns the same for a pair that stays as it is.
DisparityBounds bounds_as_given(const Estimate& estimate, double scale);

// Returns an estimate that leaves the pair as it is; near rows agree.
Estimate as_given(const Camera& camera, std::vector<Match> matches);

}  // namespace hexrelief::alignment
