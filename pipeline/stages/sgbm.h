// Matches both views by OpenCV's StereoSGBM.
#pragma once

#include <cstdint>
#include <vector>

#include "pipeline/data/disparity_map.h"
#include "pipeline/stages/disparity.h"

namespace hexrelief::stages {

// The disparities of one view as StereoSGBM gives them: row-major, in 1/16 px; kUnmatched = no match.
struct RawDisparities {
    int width = 0;
    int height = 0;
    std::vector<std::int16_t> values;
};
inline constexpr std::int16_t kUnmatched = INT16_MIN;
inline constexpr int kRawScale = 16;

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

// Unmatches speckles: patches of at most window_px connected pixels, in which neighbours differ by at most
// range_px. window_px = 0 removes none.
void remove_speckles(RawDisparities& map, int window_px, int range_px);

}  // namespace hexrelief::stages
