// Figures that distinguish a correct pair from a wrong one.
#pragma once

#include <cstdint>
#include <vector>

#include "pipeline/checks/point_matches.h"
#include "pipeline/data/disparity_map.h"
#include "pipeline/stages/disparity_range.h"

namespace hexrelief::checks {

// Returns the share of the reduced pair's pixels whose disparity both views agree on, of those that they
// could agree on: seen_share, the share of the right view that shows its picture (a corrected view has empty
// corners), in (0, 1].
double agreed_share(const stages::SmallMatch& match, double seen_share = 1);

// Returns the same share for the pair with its views swapped.
double swapped_share(const stages::SmallMatch& match, double seen_share, int threads);

// Returns the median of the disparities that both views agree on, in px of the full pair; NaN if
// they agree on none.
double median_disparity_px(const stages::SmallMatch& match);

// True if all pixels have the same colour.
bool is_blank(const Image& image);

// Returns the share of the reduced picture's blocks of 8 x 8 px that show more than noise.
double textured_share(const Image& reduced, int threads);

// Fits the right view's rows to the left's, by points of the full pair near the coarse match's disparities.
RowFit measure_rows(const StereoPair& pair, const stages::SmallMatch& coarse, int threads);

// Points of the reduced pair, searched at any disparity and up to an eighth of its height above or below
// their row, which finds points that are too far off for the coarse match.
struct CoarsePoints {
    std::vector<PointMatch> matches;  // the matches that agree with the fit
    RowFit rows;                      // in px of the full pair
};

CoarsePoints match_coarse_points(const stages::SmallMatch& coarse, int threads);

// The points below a range that begins at min_px, and those below 0, by more than half a pixel
// of the reduced pair.
struct LowEnd {
    double below_share = 0, negative_share = 0;
    double least_px = 0;  // except for one in fifty
};

LowEnd measure_low_end(const std::vector<PointMatch>& matches, double scale, int min_px);

// Returns the share of the agreed disparities that are within a pixel of the least disparity searched.
double share_at_low_end(const stages::SmallMatch& match);

// Returns the share of the agreed disparities that are within a pixel of the reduced pair of 0.
double share_at_zero(const stages::SmallMatch& match);

// Returns the mean absolute difference of the grey views at the same place, divided by that of the left view
// to its next column. This is about the disparity in px if that is below 1, and 0 for equal views.
double difference_over_slope(const StereoPair& pair);

// The agreed disparities beyond a range that ends at end_px, by more than half a pixel of the reduced pair.
struct HighEnd {
    double beyond_share = 0;
    double largest_px = 0;  // except for one in two hundred
};

HighEnd measure_high_end(const stages::SmallMatch& coarse, int end_px);

// Returns the share of the left picture's textured pixels on which both views agree, 0..1: 0 without texture.
// Texture: blocks of 8 x 8 px that show more than noise. Left out are pixels that `is_kept` sets to 0, and
// those whose disparity places them left of the right picture or where `is_seen` is 0 in it. Both masks have
// the map's size or are empty. `map` was matched.
double measure_support(const Image& left, const DisparityMap& map, const std::vector<std::uint8_t>& is_kept,
                       const std::vector<std::uint8_t>& is_seen, int threads);

// A pair's support in words: "good", "partly" or "hardly".
const char* support_word(double support);
bool is_hardly_supported(double support);

// True if the match's left view is surely the left one, whatever the sign of its disparities. Pixels that
// only one view shows lie between a near and a far surface, and belong to the far one: the picture's edge,
// the silhouette of the near surface, is their right end in a left view and their left end in a right view.
bool is_surely_left(const stages::SmallMatch& match);
// True if it is surely the right one.
bool is_surely_right(const stages::SmallMatch& match);

}  // namespace hexrelief::checks
