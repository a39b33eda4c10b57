// How two cameras stand to each other, from the points that both pictures show.
#pragma once

#include <vector>

#include "pipeline/alignment/fit.h"
#include "pipeline/base/thread_pool.h"

namespace hexrelief::alignment {

// The absolute offsets of the rows of some matches, in px of the working pictures.
struct RowFigures {
    double median_px = 0, percentile90_px = 0;
    double beyond_share = 0;  // of the matches that are off by more than 1 px
};

RowFigures row_figures(std::vector<double> offsets);

// Matches whose rows are off by less agree with an estimate.
inline constexpr double kAgreeing_px = 2;

// Which picture is the left camera's.
enum class Order {
    by_points,  // the first one, unless what both show would lie behind the cameras; a rig's is the first
    as_given,
    exchanged,
};

struct EstimateConfig {
    bool is_focal_known = false;
    // Both pictures are from one mount with two lenses: turned by a few degrees at most, and in order.
    bool is_rig = false;
    Order order = Order::by_points;
};

struct Estimate {
    // The matches as the cameras see them if both pictures are turned by a quarter to the left, so that
    // cameras that stand one above the other stand side by side; else the matches as given.
    bool is_quarter_turned = false;
    Camera camera;
    std::vector<Match> matches;
    Fit fit;
    std::vector<Match> agreeing;
    RowFigures before, after;   // of the agreeing ones
    RowFigures held_out;        // of every other one, by a fit to the rest
    bool is_exchanged = false;  // the left camera stands on the right

    // Returns the views in order, at `scale` times the size of the matches' pictures.
    Views views(double scale = 1) const;
    // Returns the agreeing matches' disparities in these views, in px of the matches' pictures.
    std::vector<double> disparities() const;
};

// Finds the parameters that most matches agree with: from three starts, of the pictures as given and turned
// by a quarter. Distortion is believed only if it lowers the offsets of matches that were not fitted. Needs
// at least 16 matches.
Estimate estimate_views(const Camera& camera, const std::vector<Match>& matches, const EstimateConfig& config,
                        ThreadPool& pool);

// Fits an estimate to other matches, given as its own are, beginning at its parameters.
Estimate with_matches(Estimate estimate, std::vector<Match> matches, const EstimateConfig& config,
                      ThreadPool& pool);

// Neighbouring matches that shift alike, but across the rows of the aligned pair: no camera explains them.
// What moves along the rows cannot be told from depth.
struct Movers {
    int points = 0;
    Point middle =
        {};  // the median of their places in the first picture, px of the matches' pictures as given
};

// Returns the movers among an estimate's matches; 0 points if they are fewer than 8 or 2 % of the matches,
// which chance and repeated patterns give.
Movers find_movers(const Estimate& estimate);

}  // namespace hexrelief::alignment
