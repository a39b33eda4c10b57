// Stage: from a rectified pair to a disparity map.
#pragma once

#include <functional>
#include <limits>
#include <string>

#include "pipeline/data/crop.h"
#include "pipeline/data/disparity_map.h"
#include "pipeline/data/value_range.h"
#include "pipeline/matching/matcher.h"
#include "pipeline/stages/disparity_range.h"

namespace hexrelief::stages {

// sgm is the matcher in pipeline/matching, sgbm is OpenCV's StereoSGBM.
enum class DisparityMethod { sgm, sgbm };
enum class SgbmMode { sgbm, hh, sgbm_3way, hh4 };
enum class DisparityFill { none, planes };
enum class Dequantization { automatic, none };

inline constexpr int kLargestPenalty = 16000;  // sums of costs have 16 bits
inline constexpr int kLargestRange_px = 1920;  // 16 bits hold 1/16 px, on planes that go beyond the range

struct DisparityConfig {
    DisparityMethod method = DisparityMethod::sgm;
    static constexpr ValueRange kMinDisparity_px{1 - kLargestRange_px, kLargestRange_px - 1};
    int min_disparity_px = 0;  // within the image's width
    // Rounded up to a multiple of 16, at most the width; 0 = chosen from the pair (the command `run` takes
    // the calibration's ndisp instead if that is known).
    static constexpr ValueRange kNumDisparities_px{0, kLargestRange_px};
    int num_disparities_px = 0;
    static constexpr ValueRange kPenalty{0, kLargestPenalty};
    // Penalty of a disparity step of 1 px; 0 = 45, or with sgbm 16 * channels * block_size^2.
    int p1 = 0;
    // Penalty of larger steps, > p1; 0 = 330, or with sgbm 64 * channels * block_size^2, at most
    // kLargestPenalty.
    int p2 = 0;
    static constexpr ValueRange kSpeckleWindow_px{0, 100000};
    int speckle_window_px = 100;  // speckles of at most this many pixels are removed; 0 = off
    static constexpr ValueRange kSpeckleRange_px{0, kLargestRange_px};
    int speckle_range_px = 2;
    // Speckles with disparities below this are removed up to four times that size; NaN =
    // farthest_disparity_px() of the pair.
    double farthest_px = std::numeric_limits<double>::quiet_NaN();
    // Largest allowed difference between the two views' disparities; < 0 = off; NaN = 0.5625, or with sgbm 1.
    double left_right_check_px = std::numeric_limits<double>::quiet_NaN();
    // Pixels without a match stay unknown, or get disparities on the planes of the matches around them.
    DisparityFill fill = DisparityFill::planes;
    // For supplied maps only (pipeline/dequantize).
    Dequantization dequantize = Dequantization::automatic;

    // Parameters of StereoSGBM only.
    bool color = false;  // match all channels; grey is faster and was measured to be better
    static constexpr ValueRange kBlockSize_px{1, 21};
    int block_size_px = 3;  // odd
    static constexpr ValueRange kPreFilterCap{1, 127};
    int pre_filter_cap = 31;  // below 15 counts as 15
    static constexpr ValueRange kUniquenessRatio_percent{0, 99};
    int uniqueness_ratio_percent = 5;
    // hh and hh4 need width * range * height * 4 bytes of memory, the other modes a few rows.
    SgbmMode mode = SgbmMode::sgbm_3way;
    // Use OpenCV's edge-preserving weighted least squares filter (ximgproc) instead of the refinement.
    bool wls = false;
    double wls_lambda = 8000;
    double wls_sigma = 1.5;
};

// Returns what is wrong with a configuration for any pair: "disparity.p1 must be ..."; empty if nothing is.
std::string wrong_disparity_config(const DisparityConfig& config);

// The matcher used by the method sgm: on the CPU, or its equal on a device.
using PairMatcher = std::function<matching::MatchedMap(const StereoPair&, const matching::MatchingConfig&)>;

// The corrections that a pair's images get before they are matched.
struct PairCorrection {
    matching::LightCurves light;  // maps the right image's light to the left image's
    // Noise by find_noise(); the right one's after its light is corrected.
    double left_noise = 0, right_noise = 0;
};

// Finds the correction from the pair's coarse match and the middle parts of both images.
PairCorrection find_correction(const SmallMatch& coarse, const Image& left_middle, Image right_middle);
// Returns the middle part of an image that find_noise() is applied to: at most 1024x1024 px.
PixelRect middle_of(int width, int height);

// A pair's search range and corrections. In `config`, num_disparities_px and farthest_px are set: the
// former, if it was 0, to a range that holds all disparities of the coarse match; the latter, if it was NaN,
// from the coarse match.
struct RangedPair {
    DisparityConfig config;
    SmallMatch coarse;
    PairCorrection correction;
};

// Throws what compute_disparity() throws, except for images that are too large. Looks at the images' sizes,
// not at their pixels.
void check_matchable(const StereoPair& pair, const DisparityConfig& config);

// Matches the pair coarsely and returns its range and corrections. Throws what compute_disparity() throws.
RangedPair find_range(const StereoPair& pair, const DisparityConfig& config, int threads);
// Returns find_range().config if num_disparities_px is 0; else rounds num_disparities_px
// up and matches nothing.
DisparityConfig with_range(const StereoPair& pair, const DisparityConfig& config, int threads);

// Returns the disparities of the left view in px (multiples of 1/16 px), and their origins. A disparity is
// never 0, which would be a point without a depth, if the range begins at 0 or above. The result is the
// same for any number of threads. Throws Error(input) if the images differ in size, have fewer than 16
// columns or more than kLargestPairSide_px on a side; Error(usage) if a parameter is out of range or the
// range is wider than the image.
DisparityMap compute_disparity(const StereoPair& pair, const DisparityConfig& config,
                               const PairMatcher& match, int threads);
// The second part of compute_disparity(): returns the pair with the right image in the left one's light and
// with less noise in both.
StereoPair corrected(StereoPair pair, const PairCorrection& correction, int threads);
// The last part of compute_disparity(): matches a corrected pair in the configuration's range. No match
// counts as far if farthest_px is NaN.
DisparityMap match_in_range(const StereoPair& pair, const DisparityConfig& config, const PairMatcher& match,
                            int threads);
// As compute_disparity() above, with the matcher of the CPU.
DisparityMap compute_disparity(const StereoPair& pair, const DisparityConfig& config, int threads);

}  // namespace hexrelief::stages
