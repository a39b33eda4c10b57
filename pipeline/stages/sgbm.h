// OpenCV's StereoSGBM on both views.
#pragma once

#include "pipeline/stages/disparity.h"
#include "pipeline/stages/view_check.h"

namespace hexrelief {

struct RawViews {
    RawDisparities left, right;
};

// Both views over the range that `config` names (num_disparities_px > 0), unchecked. The left band, whose
// matches lie outside the right image's search range, is not lost: both images are padded and the result
// cropped. The same bytes for any number of threads. Throws Error(usage) where memory is too small.
RawViews match_views_sgbm(const StereoPair& pair, const DisparityConfig& config, int threads);

// The checked left view smoothed along the left image's edges. The filter closes every hole; they are opened
// again unless filling is asked for.
void smooth_wls(RawDisparities& checked, const RawViews& unchecked, const Image& guide,
                const DisparityConfig& config);

// A multiple of 16, which StereoSGBM needs.
int round_up_range(int disparities);

}  // namespace hexrelief
