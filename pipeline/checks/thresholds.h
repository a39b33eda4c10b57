// The kinds of mistakes that an input's meaning may reveal, and the thresholds between correct inputs and
// wrong ones. Each threshold lies between the figures of correct and wrong inputs, not close to that of any
// one scene: EXPERIMENTS.md has both.
#pragma once

#include <string>

#include "pipeline/data/number_text.h"

namespace hexrelief::checks {

// Thresholds for pairs.
constexpr double kLeastTexture = 0.1;  // least share of textured blocks of the reduced picture
constexpr double kLeastAtZero = 0.98;  // views may be equal from this share of pixels at disparity 0 on
// Views may be equal up to this share of the difference to the next column.
constexpr double kMostDifference = 0.9;
constexpr double kSureAgreement = 0.8;  // share of agreed pixels; below, the pair is examined more closely
// Share of agreed pixels; below, and without agreeing points, the pair is unrelated.
constexpr double kLeastAgreement = 0.45;
constexpr int kLeastPoints = 20;  // least number of points that agree on the rows
constexpr double kLeastAgreeingPoints = 0.7;
constexpr double kLargestRow_px = 1;
// In px of the reduced pair, added to kLargestRow_px for its points.
constexpr double kLargestCoarseRow = 0.25;
// Least share of the points with a disparity below 0 in a swapped pair.
constexpr double kSwappedBelow = 0.85;
// Least share of agreed pixels the other way round in a swapped pair.
constexpr double kSwappedAgreement = 0.5;
constexpr double kMostBelow = 0.05;  // largest share of the points below the range searched
// Share of the known pixels; above, the pair is examined more closely.
constexpr double kMostAtLowEnd = 0.05;
// Largest share of the reduced picture's known pixels beyond the range.
constexpr double kMostBeyond = 0.003;
constexpr double kWidestRange = 3;  // largest range, as a multiple of the scene's need
constexpr int kFreeRange_px = 32;   // a range may always be wider than needed by this
// Share of the textured pixels on which both views agree (pair_statistics.h).
constexpr double kGoodSupport = 0.7, kLeastSupport = 0.4;

// Thresholds for maps.
constexpr int kLeastValues = 200;
constexpr int kLeastTurns = 80;
constexpr double kMostTopmost = 0.15;     // largest share of turning points at the largest value
constexpr double kLeastRoundness = 0.41;  // least roundness of these turning points
// A weighted sum of row correlation and straightness below this means depths. Planes outweigh the row: what
// is near is mostly low in the picture, but not for cameras that look down from behind or at a ceiling.
constexpr double kDepthLike = -0.25;
constexpr double kStraightnessWeight = 5;
constexpr double kLargest = 0.6;  // largest disparity, as a share of the width
// Largest disparity in maps of integers up to 255, as a share of the width.
constexpr double kLargestOfBytes = 0.17;
constexpr double kLeastOfLargest = 0.005;  // least largest disparity, as a share of the width
// The fit of the picture's edges to the map's steps, in standard deviations of what pictures have elsewhere.
constexpr int kLeastSteps = 200;
constexpr double kLeastFit = 3;          // least fit of the map's own picture
constexpr double kLeastOfColumns = 1.5;  // of the steps from left to right alone
constexpr double kShiftedFit = 5;        // least fit of a shifted or flipped picture put right
constexpr double kShiftedGain = 3;       // least increase of the fit by putting it right
constexpr int kLeastShift_px = 3;

// Thresholds for cameras.
constexpr double kLargestBaseline_m = 5;  // vehicles have 1.5 m; a phone's baseline in mm is 12
constexpr double kWidestView_deg = 135;   // across the longer side; a pinhole's picture has less
constexpr double kLeastDepth_m = 0.05, kLargestDepth_m = 1000;

// Returns a number with three digits or more: 0.0123, 1.23, 1234.
inline std::string figure(double value) {
    return value > -100 && value < 100 ? number_text(value, 3) : fixed(value, 0);
}

inline std::string percent(double share) {
    return fixed(100 * share, 0) + " %";
}

// The kinds of mistakes that an input's meaning may reveal.
enum class Mistake {
    views_equal,
    views_swapped,
    rows_differ,
    views_unrelated,
    no_texture,
    range_begins_high,
    range_ends_low,
    range_wide,
    values_are_depth,
    depths_are_inverse,
    values_are_colors,
    values_large,
    values_small,
    rows_flipped,  // against the picture
    color_mirrored,
    color_elsewhere,  // shifted against the map
    color_unrelated,
    baseline_in_mm,
    focal_in_mm,
    depth_implausible,
};

// A finding as one line: what was seen, with a figure, what it means, and what to do.
struct Finding {
    Mistake mistake;
    std::string text;
};

}  // namespace hexrelief::checks
