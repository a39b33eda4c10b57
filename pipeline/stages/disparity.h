// Stage: from a rectified pair to a disparity map.
#pragma once

#include <limits>
#include <optional>
#include <string>

#include "pipeline/data/calibration.h"
#include "pipeline/data/crop.h"
#include "pipeline/data/disparity_map.h"
#include "pipeline/data/value_range.h"
#include "pipeline/matching/matcher.h"
#include "pipeline/stages/by_colour/picture_kinds.h"
#include "pipeline/stages/disparity_range.h"

namespace hexrelief::stages {

// sgm is the matcher in pipeline/matching, sgbm is OpenCV's StereoSGBM, command a program of the user's, onnx
// a network. The last two give whole maps (refine_maps()).
enum class DisparityMethod { sgm, sgbm, command, onnx };
inline bool gives_maps(DisparityMethod method) {
    return method == DisparityMethod::command || method == DisparityMethod::onnx;
}
enum class SgbmMode { sgbm, hh, sgbm_3way, hh4 };
enum class DisparityFill { none, planes };
enum class Dequantization { automatic, none };

inline constexpr int kLargestPenalty = 16000;  // sums of costs have 16 bits
inline constexpr int kLargestRange_px = 1920;  // 16 bits hold 1/16 px, on planes that go beyond the range

struct DisparityConfig {
    DisparityMethod method = DisparityMethod::sgm;
    // For the command `run`: the longest side at which a pair is matched and meshed, 0 or from
    // kLeastWorkingSize_px on; 0 = that of its pictures.
    static constexpr ValueRange kWorkingSize_px{0, kLargestPairSide_px};
    static constexpr int kLeastWorkingSize_px = 320;
    int working_px = 3000;
    static constexpr ValueRange kMinDisparity_px{1 - kLargestRange_px, kLargestRange_px - 1};
    int min_disparity_px = 0;  // within the image's width
    // Rounded up to a multiple of 16, at most the width; 0 = chosen from the pair (the command `run` takes
    // the calibration's ndisp instead if that is known).
    static constexpr ValueRange kNumDisparities_px{0, kLargestRange_px};
    int num_disparities_px = 0;
    static constexpr ValueRange kPenalty{0, kLargestPenalty};
    // Penalty of a disparity step of 1 px; 0 = 45, or with sgbm 16 * channels * block_size^2.
    int p1 = 0;
    // Penalty of larger steps, > p1; 0 = 330, or with sgbm 64 * channels *
    // block_size^2, at most kLargestPenalty.
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
    // For supplied maps only (pipeline/stages/dequantize).
    Dequantization dequantize = Dequantization::automatic;

    // Of command only: a line of words, which no shell reads. command is run for each view; {left}, {right},
    // {out} and {ndisp} in it are replaced. worker is run once for all pairs of a process, and asked by lines
    // of JSON.
    std::string command = {}, worker = {};
    // Of onnx only: the network's file, and its row of config/models.yaml; empty = by the file.
    std::string model = {}, model_kind = {};
    // Of command and onnx.
    static constexpr ValueRange kTimeout_s{1, 86400};
    double timeout_s = 600;  // for a view
    static constexpr ValueRange kConfidence{0, 1};
    double least_confidence = 0.1;  // pixels of lower confidence are unknown, if there are confidences

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
};

// The matcher behind sgm: match_pair() of pipeline/matching, or the same on a device.
class PairMatcher {
  public:
    virtual ~PairMatcher() = default;
    virtual matching::MatchedMap match_pair(const StereoPair& pair,
                                            const matching::MatchingConfig& config) = 0;
};

class CpuMatcher final : public PairMatcher {
  public:
    explicit CpuMatcher(int threads) : threads_(threads) {}
    matching::MatchedMap match_pair(const StereoPair& pair, const matching::MatchingConfig& config) override;

  private:
    int threads_;
};

// Returns the mistake in a configuration that no pair can have: "disparity.p1 must be ..."; empty = none.
std::string wrong_disparity_config(const DisparityConfig& config);

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

// The range to search in a pair, and the coarse match that it is found by.
struct FoundRange {
    DisparityConfig config;  // with num_disparities_px and farthest_px
    RangeOrigin origin = RangeOrigin::chosen;
    SmallMatch coarse = {};
    PairCorrection correction = {};
};

// Throws what compute_disparity() throws, except for images that are too large. Looks at the images' sizes,
// not at their pixels.
void check_matchable(const StereoPair& pair, const DisparityConfig& config);

// Returns the number of disparities below a calibration's ndisp that can be searched in pictures of this
// width; 0 if the configuration has a range of its own, or the calibration has no ndisp.
int num_disparities_by(const Calibration& calibration, const DisparityConfig& config, int width);

// Returns the configuration's range, else the calibration's, else the range that holds the disparities of the
// coarse match. The coarse match also gives farthest_px if that is NaN. Throws as match_range().
FoundRange find_range(const StereoPair& pair, const Calibration& calibration, const DisparityConfig& config,
                      int threads);

// Returns the pair with the right image in the left image's light and with less noise in both, for matching.
StereoPair corrected(StereoPair pair, const PairCorrection& correction, int threads);

// Returns disparities of the left view in px (multiples of 1/16 px) and their origins. What lies between two
// surfaces at a silhouette is given to these (without_mixed_pixels(); scraps stay). A range from 0 or
// above gives no disparity of 0, which would be a point without a depth. config: FoundRange::config; if
// farthest_px is NaN, no match counts as far. The same bytes for any number of threads. Throws Error(input)
// if the images differ in size, have fewer than 16 columns or more than kLargestPairSide_px; Error(usage) for
// a parameter out of range, or a range wider than the image. planes: of these pictures, bare patches follow
// planes (with_planes_on_bare_patches()); a part of a pair does not show whole patches, and has none.
DisparityMap match_range(const StereoPair& pair, const DisparityConfig& config, PairMatcher& matcher,
                         int threads, std::optional<Pictures> planes = {});

// The disparities of both views, each at its own columns.
struct ViewMaps {
    DisparityMap left, right;
    // True if a matcher gave a disparity to nearly every pixel, as networks do. Pixels of low confidence are
    // unknown in the maps nevertheless.
    bool is_dense = false;
};

// Returns the left view's disparities as match_range() does, from both views' maps of another matcher, whose
// range is what they hold. Throws Error(input) if it is wider than kLargestRange_px.
DisparityMap refine_maps(const StereoPair& pair, const ViewMaps& views, const DisparityConfig& config,
                         int threads);

// Calls find_range(), corrected() and match_range() for a pair without a calibration; on the CPU if
// no matcher is given.
DisparityMap compute_disparity(const StereoPair& pair, const DisparityConfig& config, PairMatcher& matcher,
                               int threads);
DisparityMap compute_disparity(const StereoPair& pair, const DisparityConfig& config, int threads);

}  // namespace hexrelief::stages
