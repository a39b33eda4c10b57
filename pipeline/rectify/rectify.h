// Rectifies a pair: turns both cameras side by side, without distortion.
#pragma once

#include <cstdint>
#include <vector>

#include "pipeline/data/calibration.h"
#include "pipeline/data/disparity_map.h"
#include "pipeline/data/stereo_calibration.h"

namespace hexrelief::rectify {

struct RectifiedPair {
    StereoPair pair;          // of the size that it came in
    Calibration calibration;  // metric; doffs_px is 0
    // Of the left view, row-major, top row first: 1 = inside of the picture as taken; what is outside is
    // black.
    std::vector<std::uint8_t> seen;
};

// By cv::stereoRectify, or cv::fisheye's: points at infinity get disparity 0, and the view is scaled so that
// nearly every pixel of both pictures shows something (alpha 0, balance 0), which cuts away what only one
// corner saw. The pictures are resampled linearly, to 1/32 px, with the same bytes on any number of threads.
// Both pictures and the calibration have one size. Throws Error(input) where the cameras do not stand side by
// side (one above the other, or the right one on the left), a side has more than kLargestPairSide_px, or no
// view is left of them.
RectifiedPair rectify(const StereoPair& pair, const StereoCalibration& calibration, int threads);

}  // namespace hexrelief::rectify
