// Rectifies a pair: turns both cameras side by side and removes distortion.
#pragma once

#include <cstdint>
#include <vector>

#include "pipeline/data/calibration.h"
#include "pipeline/data/disparity_map.h"

namespace hexrelief::alignment {

struct RectifiedPair {
    StereoPair pair;          // of the same size as the input
    Calibration calibration;  // metric; doffs_px is 0
    // For each pixel of the left view, row-major, top row first: 1 = inside the picture as taken;
    // pixels outside are black.
    std::vector<std::uint8_t> seen;
};

// Rectifies by cv::stereoRectify, or by cv::fisheye's. Points at infinity get disparity 0. The view is scaled
// so that nearly every pixel of both pictures shows something (alpha 0, balance 0), which cuts away what only
// a corner shows. The pictures are resampled linearly, to 1/32 px; the result is the same for any number of
// threads. Both pictures and the calibration have one size. Throws Error(input) if the cameras are not side
// by side (one above the other, or the right one on the left), if a side has more than kLargestPairSide_px,
// or if no view of both is left.
RectifiedPair rectify(const StereoPair& pair, const StereoCalibration& calibration, int threads);

}  // namespace hexrelief::alignment
