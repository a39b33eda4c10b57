// Stage: rectified pair -> disparity map, by OpenCV's semi-global block matching.
#pragma once

#include "pipeline/data/disparity_map.h"

namespace hexrelief {

enum class SgbmMode { sgbm, hh, sgbm_3way, hh4 };

struct DisparityConfig {
    int min_disparity_px = 0;
    // Rounded up to a multiple of 16, at most the width; 0 = chosen from the pair.
    int num_disparities_px = 0;
    bool color = false;       // match all channels; grey is faster and, measured, better
    int block_size_px = 3;    // odd, 1..21
    int p1 = 0;               // penalty of a step of 1 px, 0..16000; 0 = 16 * channels * block_size^2
    int p2 = 0;               // of larger steps, > p1; 0 = 64 * channels * block_size^2, at most 16000
    int pre_filter_cap = 31;  // 1..127; below 15 counts as 15
    int uniqueness_ratio_percent = 5;  // 0..100
    int speckle_window_px = 100;       // 0 = off
    int speckle_range_px = 2;
    // hh and hh4 keep width * range * height * 4 bytes, the others a few rows.
    SgbmMode mode = SgbmMode::sgbm_3way;
    double left_right_check_px = 1.0;  // largest allowed difference of the two views' disparities; < 0 = off
    bool wls = false;                  // edge-preserving weighted least squares filter (OpenCV ximgproc)
    double wls_lambda = 8000;
    double wls_sigma = 1.5;
    bool fill = false;  // fill unknown pixels from the farther of their row neighbours
};

// Returns disparities of the left view in px (sub-pixel, 1/16), unknown where matching failed. The left band,
// whose matches lie outside the right image's search range, is not lost: both images are padded and the
// result cropped. The same bytes for any number of threads. Throws Error(input) where the images differ in
// size or have fewer than 16 columns; Error(usage) for a range wider than the image.
DisparityMap compute_disparity(const StereoPair& pair, const DisparityConfig& config, int threads);

// How a map compares with ground truth, over the pixels known in the truth. Bad counts unknown estimates as
// bad.
struct DisparityEvaluation {
    double bad_percent[4] = {};   // error above 0.5, 1, 2, 4 px, percent of the truth's known pixels
    double average_error_px = 0;  // over the pixels known in both
    double rms_error_px = 0;      // likewise
    double coverage_percent = 0;  // known in both / known in truth
    long long truth_pixels = 0;
};
inline constexpr double kBadThresholds_px[4] = {0.5, 1, 2, 4};

// Throws Error(input) where the sizes differ or the truth has no known pixel.
DisparityEvaluation evaluate_disparity(const DisparityMap& map, const DisparityMap& truth);

}  // namespace hexrelief
