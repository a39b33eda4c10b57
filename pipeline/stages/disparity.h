// Stage: rectified pair -> disparity map.
#pragma once

#include <limits>

#include "pipeline/data/calibration.h"
#include "pipeline/data/crop.h"
#include "pipeline/data/disparity_map.h"
#include "pipeline/matching/matcher.h"
#include "pipeline/stages/disparity_range.h"

namespace hexrelief {

// sgm: pipeline/matching; sgbm: OpenCV's StereoSGBM.
enum class DisparityMethod { sgm, sgbm };
enum class SgbmMode { sgbm, hh, sgbm_3way, hh4 };
enum class DisparityFill { none, planes };
enum class Dequantization { automatic, none };

struct DisparityConfig {
    DisparityMethod method = DisparityMethod::sgm;
    int min_disparity_px = 0;
    // Rounded up to a multiple of 16, at most the width; 0 = the calibration's ndisp, or chosen from the pair
    // where there is none.
    int num_disparities_px = 0;
    // Penalty of a disparity step of 1 px, 0..16000; 0 = 45, with sgbm 16 * channels * block_size^2.
    int p1 = 0;
    // Of larger steps, > p1; 0 = 330, with sgbm 64 * channels * block_size^2, at most 16000.
    int p2 = 0;
    int speckle_window_px = 100;  // patches of at most as many pixels are removed; 0 = off
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
    bool color = false;                // match all channels; grey is faster and, measured, better
    int block_size_px = 3;             // odd, 1..21
    int pre_filter_cap = 31;           // 1..127; below 15 counts as 15
    int uniqueness_ratio_percent = 5;  // 0..100
    // hh and hh4 keep width * range * height * 4 bytes, the others a few rows.
    SgbmMode mode = SgbmMode::sgbm_3way;
    // Edge-preserving weighted least squares filter (OpenCV ximgproc) in place of the refinement.
    bool wls = false;
    double wls_lambda = 8000;
    double wls_sigma = 1.5;
};

// What sgm matches by: pipeline/matching's match_pair(), or the same on a device.
class PairMatcher {
  public:
    virtual ~PairMatcher() = default;
    virtual MatchedMap match_pair(const StereoPair& pair, const MatchingConfig& config) = 0;
};

class CpuMatcher final : public PairMatcher {
  public:
    explicit CpuMatcher(int threads) : threads_(threads) {}
    MatchedMap match_pair(const StereoPair& pair, const MatchingConfig& config) override;

  private:
    int threads_;
};

// What is done to the pictures before they are matched.
struct PairCorrection {
    LightCurves light;                       // of the right one, which gets the left one's
    double left_noise = 0, right_noise = 0;  // as find_noise() has it, of the right one in its new light
};

// By the pair's coarse match, and the pictures' middles.
PairCorrection find_correction(const SmallMatch& coarse, const Image& left_middle, Image right_middle);
// The middle that tells a picture's noise: at most 1024x1024 px.
PixelRect middle_of(int width, int height);

// The range to search in a pair, and what both views agree on at a small size, which tells it.
struct FoundRange {
    DisparityConfig config;  // with num_disparities_px and farthest_px
    RangeOrigin origin = RangeOrigin::chosen;
    SmallMatch coarse = {};
    PairCorrection correction = {};
};

// Throws as match_range(), but not for large images. Looks at their sizes alone, not at pixels.
void check_matchable(const StereoPair& pair, const DisparityConfig& config);

// The disparities below a calibration's ndisp that can be searched in pictures of this width; 0 where the
// configuration has a range of its own, or the calibration says none.
int num_disparities_by(const Calibration& calibration, const DisparityConfig& config, int width);

// The configuration's own range, else the calibration's, else the one that holds the disparities of the
// coarse match, which also say what farthest_px is where that is NaN. Throws as match_range().
FoundRange find_range(const StereoPair& pair, const Calibration& calibration, const DisparityConfig& config,
                      int threads);

// The pair in the left picture's light and with less noise, as it is best matched.
StereoPair corrected(StereoPair pair, const PairCorrection& correction, int threads);

// Returns disparities of the left view in px (1/16 px), and where they come from. Never 0, which would be a
// point without a depth, where the range begins at 0 or above. config: FoundRange's; no match is far where
// farthest_px is NaN. The same bytes for any number of threads. Throws Error(input) where the images differ
// in size, have fewer than 16 columns or more than kLargestPairSide_px; Error(usage) for a parameter out of
// range, or a range wider than the image.
DisparityMap match_range(const StereoPair& pair, const DisparityConfig& config, PairMatcher& matcher,
                         int threads);

// The three in turn, for a pair of which no calibration is known; on the CPU where no matcher is given.
DisparityMap compute_disparity(const StereoPair& pair, const DisparityConfig& config, PairMatcher& matcher,
                               int threads);
DisparityMap compute_disparity(const StereoPair& pair, const DisparityConfig& config, int threads);

}  // namespace hexrelief
