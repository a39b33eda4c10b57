// Matches both views by OpenCV's StereoSGBM.
#pragma once

#include "pipeline/stages/disparity.h"
#include "pipeline/stages/view_check.h"

namespace hexrelief::stages {

struct RawViews {
    RawDisparities left, right;
};

// Matches both views over the configuration's range (num_disparities_px > 0), without checking them against
// each other. The left band, whose matches lie outside the right image's search range, is not lost: both
// images are padded and the result is cropped. The result is the same for any number of threads. Throws
// Error(usage) if there is too little memory.
RawViews match_views_sgbm(const StereoPair& pair, const DisparityConfig& config, int threads);

// Rounds up to a multiple of 16, which StereoSGBM needs.
int round_up_range(int disparities);

}  // namespace hexrelief::stages
