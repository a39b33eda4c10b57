// What tells a right pair from a wrong one, in figures.
#pragma once

#include <vector>

#include "pipeline/checks/point_matches.h"
#include "pipeline/data/disparity_map.h"
#include "pipeline/stages/disparity_range.h"

namespace hexrelief::checks {

// Share of the reduced pair's pixels whose disparity both views agree on.
double agreed_share(const stages::SmallMatch& match);

// The same of the pair with its views swapped.
double swapped_share(const stages::SmallMatch& match, int threads);

// Half of what both views agree on has a smaller disparity, in px of the full pair. NaN where they agree on
// nothing.
double median_disparity_px(const stages::SmallMatch& match);

// One colour everywhere.
bool is_blank(const Image& image);

// Share of the reduced picture's blocks of 8 x 8 px that show more than noise.
double textured_share(const Image& reduced);

// Rows of the right view against the left's, by points of the full pair near the coarse match's disparities.
RowFit measure_rows(const StereoPair& pair, const stages::SmallMatch& coarse);

// Points of the reduced pair at any disparity and up to an eighth of its height above or below their row:
// finds what is too far off for the coarse match.
struct CoarsePoints {
    std::vector<PointMatch> matches;  // those that agree with the fit
    RowFit rows;                      // in px of the full pair
};

CoarsePoints match_coarse_points(const stages::SmallMatch& coarse);

// Points below a range that begins at min_px, and below 0, by more than half a pixel of the reduced pair.
struct LowEnd {
    double below_share = 0, negative_share = 0;
    double least_px = 0;  // but for one in fifty
};

LowEnd measure_low_end(const std::vector<PointMatch>& matches, double scale, int min_px);

// Share of what both views agree on within a pixel of the least disparity that was searched.
double share_at_low_end(const stages::SmallMatch& match);

// Share of what both views agree on within a pixel of the reduced pair of no disparity at all.
double share_at_zero(const stages::SmallMatch& match);

// The grey views' mean absolute difference at the same place in that of the left one to its next column:
// about the disparity in px where that is below 1, and 0 of equal views.
double difference_over_slope(const StereoPair& pair);

// What both views agree on beyond a range that ends at end_px, by more than half a pixel of the reduced pair.
struct HighEnd {
    double beyond_share = 0;
    double largest_px = 0;  // but for one in two hundred
};

HighEnd measure_high_end(const stages::SmallMatch& coarse, int end_px);

}  // namespace hexrelief::checks
