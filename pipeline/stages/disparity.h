// Stage: rectified pair -> disparity map.
#pragma once

#include <functional>
#include <limits>
#include <string>

#include "pipeline/data/crop.h"
#include "pipeline/data/disparity_map.h"
#include "pipeline/data/value_range.h"
#include "pipeline/matching/matcher.h"
#include "pipeline/stages/disparity_range.h"

namespace hexrelief {

// sgm: pipeline/matching; sgbm: OpenCV's StereoSGBM.
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
    // Rounded up to a multiple of 16, at most the width; 0 = chosen from the pair (by run: the
    // calibration's ndisp, where it says one).
    static constexpr ValueRange kNumDisparities_px{0, kLargestRange_px};
    int num_disparities_px = 0;
    static constexpr ValueRange kPenalty{0, kLargestPenalty};
    // Penalty of a disparity step of 1 px; 0 = 45, with sgbm 16 * channels * block_size^2.
    int p1 = 0;
    // Of larger steps, > p1; 0 = 330, with sgbm 64 * channels * block_size^2, at most kLargestPenalty.
    int p2 = 0;
    static constexpr ValueRange kSpeckleWindow_px{0, 100000};
    int speckle_window_px = 100;  // patches of at most as many pixels are removed; 0 = off
    static constexpr ValueRange kSpeckleRange_px{0, kLargestRange_px};
    int speckle_range_px = 2;
    // Patches of matches of a smaller disparity are removed up to four times that size; NaN =
    // farthest_disparity_px() of the pair.
    double farthest_px = std::numeric_limits<double>::quiet_NaN();
    // Largest allowed difference of the two views' disparities; < 0 = off; NaN = 0.5625, with sgbm 1.
    double left_right_check_px = std::numeric_limits<double>::quiet_NaN();
    // Pixels without a match: unknown, or on the planes of those around them.
    DisparityFill fill = DisparityFill::planes;
    // Of a supplied map (pipeline/dequantize).
    Dequantization dequantize = Dequantization::automatic;

    // StereoSGBM's own.
    bool color = false;  // match all channels; grey is faster and, measured, better
    static constexpr ValueRange kBlockSize_px{1, 21};
    int block_size_px = 3;  // odd
    static constexpr ValueRange kPreFilterCap{1, 127};
    int pre_filter_cap = 31;  // below 15 counts as 15
    static constexpr ValueRange kUniquenessRatio_percent{0, 99};
    int uniqueness_ratio_percent = 5;
    // hh and hh4 keep width * range * height * 4 bytes, the others a few rows.
    SgbmMode mode = SgbmMode::sgbm_3way;
    // Edge-preserving weighted least squares filter (OpenCV ximgproc) in place of the refinement.
    bool wls = false;
    double wls_lambda = 8000;
    double wls_sigma = 1.5;
};

// What is wrong with a configuration, whatever the pair: "disparity.p1 must be ...". Empty = nothing.
std::string wrong_disparity_config(const DisparityConfig& config);

// The matcher that sgm calls: the CPU's, or the same on a device.
using PairMatcher = std::function<MatchedMap(const StereoPair&, const MatchingConfig&)>;

// What is done to the pictures before they are matched.
struct PairCorrection {
    LightCurves light;                       // of the right one, which gets the left one's
    double left_noise = 0, right_noise = 0;  // as find_noise() has it, of the right one in its new light
};

// By the pair's coarse match, and the pictures' middles.
PairCorrection find_correction(const SmallMatch& coarse, const Image& left_middle, Image right_middle);
// The middle that tells a picture's noise: at most 1024x1024 px.
PixelRect middle_of(int width, int height);

// The configuration with the range that compute_disparity() searches, and what both views of the pair agree
// on at a small size: where num_disparities_px is 0, the range is the one that holds those disparities, and
// they say what farthest_px is where that is NaN.
struct RangedPair {
    DisparityConfig config;
    SmallMatch coarse;
    PairCorrection correction;
};

// Throws as compute_disparity(), but not for large images. Looks at their sizes alone, not at pixels.
void check_matchable(const StereoPair& pair, const DisparityConfig& config);

// Throws as compute_disparity().
RangedPair find_range(const StereoPair& pair, const DisparityConfig& config, int threads);
// The configuration alone, which takes no match where the range is given.
DisparityConfig with_range(const StereoPair& pair, const DisparityConfig& config, int threads);

// Returns disparities of the left view in px (1/16 px), and where they come from. Never 0, which would be a
// point without a depth, where the range begins at 0 or above. The same bytes for any number of threads.
// Throws Error(input) where the images differ in size, have fewer than 16 columns or more than
// kLargestPairSide_px; Error(usage) for a
// parameter out of range, or a range wider than the image.
DisparityMap compute_disparity(const StereoPair& pair, const DisparityConfig& config,
                               const PairMatcher& match, int threads);
// Its last two parts alone: the pair in the left picture's light and with less noise, and such a pair matched
// in the configuration's range; no match is far where farthest_px is NaN.
StereoPair corrected(StereoPair pair, const PairCorrection& correction, int threads);
DisparityMap match_in_range(const StereoPair& pair, const DisparityConfig& config, const PairMatcher& match,
                            int threads);
// The same on the CPU.
DisparityMap compute_disparity(const StereoPair& pair, const DisparityConfig& config, int threads);

}  // namespace hexrelief
