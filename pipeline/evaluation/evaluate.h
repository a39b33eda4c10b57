// How a disparity map compares with ground truth.
#pragma once

#include "pipeline/data/disparity_map.h"

namespace hexrelief::evaluation {

inline constexpr double kBadThresholds_px[4] = {0.5, 1, 2, 4};

struct EvaluationConfig {
    // Truth of the right view, of the left one's size. Without it a pixel counts as hidden in the right view
    // where the left truth puts something nearer on the same right pixel.
    const DisparityMap* right_truth = nullptr;
    // Neighbours in the truth that differ by more are a discontinuity; > 0. Middlebury's scenes: 1 at up to
    // half size, 2 at full size.
    // The windows of the roughness begin 4 times as many px apart, 1 to 64.
    double discontinuity_px = 1;
};

// All shares are percent, and 0 where nothing was there to count. A disparity of 0 counts as unknown in both
// maps, as it does in the files. Bad counts unknown estimates as bad.
struct DisparityEvaluation {
    double bad_percent[4] = {};   // error above 0.5, 1, 2, 4 px, of the truth's known pixels
    double average_error_px = 0;  // over the pixels known in both
    double rms_error_px = 0;      // likewise
    double coverage_percent = 0;  // known in both, of those known in the truth
    long long truth_pixels = 0;

    double bad_nonoccluded_percent[4] = {};  // of the known pixels that the right view sees as well
    double bad_known_percent[4] = {};        // of the pixels known in both
    long long nonoccluded_pixels = 0;

    // Of the known pixels within 3 px of a true discontinuity: estimates nearer to the wrong side of it than
    // to the right one, and unknown ones.
    double edge_wrong_percent = 0;
    double edge_unknown_percent = 0;
    long long edge_pixels = 0;

    // RMS of the estimates against the plane through them on 9x9 windows where the truth is a slanted plane;
    // deviations above 2 px count as 2 px. A window with an unknown pixel is left out.
    double roughness_px = 0;
    long long roughness_windows = 0;
};

// Throws Error: input where the sizes differ or the truth has no known pixel, usage for a discontinuity_px
// that is not above 0.
DisparityEvaluation evaluate_disparity(const DisparityMap& map, const DisparityMap& truth,
                                       const EvaluationConfig& config = {});

}  // namespace hexrelief::evaluation
