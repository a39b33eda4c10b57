// Compares a disparity map with ground truth.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "pipeline/data/disparity_map.h"

namespace hexrelief::evaluation {

inline constexpr double kBadThresholds_px[4] = {0.5, 1, 2, 4};

struct EvaluationConfig {
    // Ground truth of the right view, of the same size. Without it a pixel counts as hidden in the right view
    // if the left truth has a nearer surface at the same right pixel.
    const DisparityMap* right_truth = nullptr;
    // Neighbours in the truth that differ by more are a discontinuity; > 0. Middlebury's scenes: 1 at up to
    // half size, 2 at full size. The windows of the roughness are this times 4 px apart, limited to 1 .. 64.
    double discontinuity_px = 1;
};

// The result. All shares are in percent, and 0 if there was nothing to count. A disparity of 0 counts as
// unknown in both maps, as in the files. Unknown estimates count as bad.
struct DisparityEvaluation {
    double bad_percent[4] = {};   // share of the truth's known pixels with an error above 0.5, 1, 2, 4 px
    double average_error_px = 0;  // over the pixels known in both
    double rms_error_px = 0;      // over the pixels known in both
    double coverage_percent = 0;  // share of the pixels known in the truth that are known in both
    long long truth_pixels = 0;

    double bad_nonoccluded_percent[4] = {};  // over the known pixels that the right view sees as well
    double bad_known_percent[4] = {};        // over the pixels known in both
    long long nonoccluded_pixels = 0;

    // Shares of the known pixels within 3 px of a true discontinuity: estimates nearer to the wrong side of
    // it than to the right one, and unknown estimates.
    double edge_wrong_percent = 0;
    double edge_unknown_percent = 0;
    long long edge_pixels = 0;

    // RMS deviation of the estimates from the plane through them, on 9x9 windows in which the truth is a
    // slanted plane; deviations above 2 px count as 2 px. Windows with an unknown pixel are left out.
    double roughness_px = 0;
    long long roughness_windows = 0;
};

// Evaluates a map. Throws Error(input) if the sizes differ or the truth has no known pixel, Error(usage) if
// discontinuity_px is not above 0.
DisparityEvaluation evaluate_disparity(const DisparityMap& map, const DisparityMap& truth,
                                       const EvaluationConfig& config = {});

// Returns all figures by their names, with their units; numbers are not rounded.
nlohmann::ordered_json evaluation_json(const DisparityEvaluation& evaluation);

}  // namespace hexrelief::evaluation
