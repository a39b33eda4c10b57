#include "pipeline/checks/checks.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "pipeline/checks/edge_fit.h"
#include "pipeline/checks/pair_statistics.h"

namespace hexrelief::checks {
namespace {

// Checks the median depth. Finds nothing if half of the scene is at infinity (sky) or the median is unknown.
std::vector<Finding> check_depth(const Calibration& camera, double median_disparity_px,
                                 const std::string& advice) {
    const double depth_m = camera.focal_px * camera.baseline_m / (median_disparity_px + camera.doffs_px);
    if (!(depth_m > 0) || std::isinf(depth_m) || (depth_m >= kLeastDepth_m && depth_m <= kLargestDepth_m))
        return {};
    return {{Mistake::depth_implausible,
             "half of the scene lies " +
                 (depth_m < kLeastDepth_m ? "nearer than " + figure(1000 * depth_m) + " mm"
                                          : "farther than " + figure(depth_m) + " m") +
                 ", which looks like wrong units; " + advice}};
}

constexpr const char* kScale = "--disparity-scale (input.disparity.scale)";

using Findings = std::vector<Finding>;

// What tells whether what is near has the larger values.
struct Uprightness {
    double row_correlation = 0, straightness = 0;

    double sum() const { return row_correlation + kStraightnessWeight * straightness; }

    // Returns the evidence that the values are those of depths.
    std::string text() const {
        std::string seen;
        if (row_correlation < 0)
            seen =
                "they grow upwards in the picture, rank correlation with the row " + figure(row_correlation);
        if (straightness < 0)
            seen += std::string(seen.empty() ? "" : "; ") + "planes are straight in their reciprocals";
        return seen;
    }
};

Finding values_are_depth(const Uprightness& upright) {
    return {Mistake::values_are_depth,
            "the map's values look like depths, not disparities: what is near has the smaller ones (" +
                upright.text() + "); give depths with --depth"};
}

Finding depths_are_inverse(const Uprightness& upright) {
    return {Mistake::depths_are_inverse,
            "the depths look upside down: what is near has the larger ones (as disparities, " +
                upright.text() +
                "); give disparities with --disparity, inverse depths with --depth-kind inverse_depth, a "
                "network's guess with affine_inverse"};
}

Finding values_are_colors(const TurningPoints& turns) {
    return {Mistake::values_are_colors,
            "the map looks like the grey of a colour-mapped picture: " + percent(turns.topmost_share) +
                " of the places where its values turn are folds at the largest one; give the "
                "disparities themselves, not a picture of them"};
}

Finding values_large(const MapValues& values, int width) {
    const bool bytes = values.are_bytes && values.largest_px <= width;
    return {Mistake::values_large,
            "the map's disparities go up to " + figure(values.largest_px) + " px, " +
                percent(values.largest_px / width) + " of the picture's width" +
                (bytes ? ": 8-bit maps mostly count parts of a pixel; give " + std::string(kScale) +
                             ", for Middlebury's 2 to 16"
                       : ": too large for a rectified pair; give " + std::string(kScale) +
                             ", for 16-bit maps as KITTI's 256")};
}

Finding values_small(const MapValues& values, int width) {
    return {Mistake::values_small, "the map's disparities go up to " + figure(values.largest_px) +
                                       " px only, " + figure(100 * values.largest_px / width) +
                                       " % of the picture's width; give " + std::string(kScale) +
                                       ", for 16-bit maps of whole pixels 1 instead of KITTI's 256"};
}

Uprightness uprightness(const DisparityMap& map, const MapValues& values) {
    return {values.row_correlation, measure_straightness(map)};
}

std::optional<Finding> check_depths(const DisparityMap& map) {
    const MapValues values = measure_values(map);
    if (values.count < kLeastValues) return std::nullopt;
    const Uprightness upright = uprightness(map, values);
    if (upright.sum() >= kDepthLike) return std::nullopt;
    return depths_are_inverse(upright);
}

std::optional<Finding> check_values(const DisparityMap& map, const MapScale& stored) {
    const MapValues values = measure_values(map);
    if (values.count < kLeastValues) return std::nullopt;
    const TurningPoints turns = are_greys(map, stored) ? measure_turning(map) : TurningPoints();
    if (turns.count >= kLeastTurns && turns.topmost_share > kMostTopmost && turns.roundness < kLeastRoundness)
        return values_are_colors(turns);
    const bool large = values.largest_px > kLargest * map.width;
    const bool small = values.largest_px < kLeastOfLargest * map.width;
    const Uprightness upright = uprightness(map, values);
    if (upright.sum() < (large || small ? 0 : kDepthLike)) return values_are_depth(upright);
    if (large || (values.are_bytes && values.largest_px > kLargestOfBytes * map.width))
        return values_large(values, map.width);
    if (small) return values_small(values, map.width);
    return std::nullopt;
}

std::string shift_text(int px, const char* positive, const char* negative) {
    return std::to_string(std::abs(px)) + " px " + (px > 0 ? positive : negative);
}

// A place of the picture under the map: turned first, then moved.
struct Placement {
    bool is_flipped = false, is_mirrored = false;  // rows, columns in the other order
    int right_px = 0, down_px = 0;
};

Image placed(const Image& image, const Placement& place) {
    Image result = image;
    const auto from = [](int at, int moved, int size, bool is_turned) {
        const int inside = std::clamp(at - moved, 0, size - 1);
        return is_turned ? size - 1 - inside : inside;
    };
    for (int y = 0; y < image.height; ++y)
        for (int x = 0; x < image.width; ++x)
            std::copy_n(image.at(from(x, place.right_px, image.width, place.is_mirrored),
                                 from(y, place.down_px, image.height, place.is_flipped)),
                        image.channels, result.at(x, y));
    return result;
}

struct PlacedFit {
    Placement place;
    double fit = 0;
};

// Returns the place where the picture fits better than where it lies, by enough to say so; the best of them.
std::optional<PlacedFit> better_place(const DisparityMap& map, const Image& left, double here,
                                      const std::vector<Placement>& places) {
    std::optional<PlacedFit> best;
    for (const Placement& place : places) {
        const std::optional<double> fit = fit_of(measure_edge_fit(map, placed(left, place)));
        if (fit && *fit >= kShiftedFit && *fit - here >= kShiftedGain && (!best || *fit > best->fit))
            best = {place, *fit};
    }
    return best;
}

// A picture or a map with its rows or columns in the other order fits only if they are exchanged.
std::optional<Finding> check_turn(const DisparityMap& map, const Image& left, double here) {
    if (here >= kShiftedFit) return std::nullopt;
    const auto turned = better_place(map, left, here, {{.is_flipped = true}, {.is_mirrored = true}});
    if (!turned) return std::nullopt;
    const bool is_flipped = turned->place.is_flipped;
    return Finding{
        is_flipped ? Mistake::rows_flipped : Mistake::color_mirrored,
        std::string(is_flipped ? "the map is upside down against the colour image"
                               : "the colour image is mirrored against the map") +
            ": the picture's edges fit the map's steps by " + figure(here) + " standard deviations, and by " +
            figure(turned->fit) + " with the " + (is_flipped ? "rows" : "columns") + " in the other order; " +
            (is_flipped ? "--flip exchanges the map's rows" : "give the picture that is not mirrored")};
}

// Each axis says where its own edges would fit best. That is a shift if both axes together fit better there.
std::optional<Finding> check_shift(const DisparityMap& map, const Image& left, const EdgeFit& fit,
                                   double here) {
    const auto shift_of = [](const AxisFit& axis) {
        return axis.steps >= kLeastSteps && std::abs(axis.best_px) >= kLeastShift_px ? axis.best_px : 0;
    };
    const int right_px = shift_of(fit.columns), down_px = shift_of(fit.rows);
    std::vector<Placement> places;
    if (right_px != 0) places.push_back({.right_px = -right_px});
    if (down_px != 0) places.push_back({.down_px = -down_px});
    if (places.size() == 2) places.push_back({.right_px = -right_px, .down_px = -down_px});
    const auto back = better_place(map, left, here, places);
    if (!back) return std::nullopt;
    const bool columns = back->place.right_px != 0, rows = back->place.down_px != 0;
    return Finding{Mistake::color_elsewhere,
                   "the colour image is shifted against the map: its edges lie " +
                       (columns ? shift_text(right_px, "right of", "left of") : std::string()) +
                       (columns && rows ? " and " : "") +
                       (rows ? shift_text(down_px, "below", "above") : std::string()) +
                       " the map's steps; give the picture of the map's own view, uncropped"};
}

std::optional<Finding> check_color(const DisparityMap& map, const Image& left) {
    const EdgeFit fit = measure_edge_fit(map, left);
    const std::optional<double> here = fit_of(fit);
    if (!here) return std::nullopt;
    if (auto turned = check_turn(map, left, *here)) return turned;
    if (auto shifted = check_shift(map, left, fit, *here)) return shifted;
    // A picture of a camera beside the map's has the map's rows, and only the steps along them tell.
    const bool columns_differ = fit.columns.steps >= kLeastSteps && fit.columns.here < kLeastOfColumns;
    if (*here >= kLeastFit && !columns_differ) return std::nullopt;
    return Finding{
        Mistake::color_unrelated,
        "the colour image does not fit the map: its edges lie at the map's steps no more than at other "
        "places (by " +
            figure(*here < kLeastFit ? *here : fit.columns.here) +
            " standard deviations); check that --color is the left picture"};
}

bool is_sure(const RowFit& fit) {
    return fit.points >= kLeastPoints && fit.agreeing_share >= kLeastAgreeingPoints;
}

Finding views_equal(const std::string& same) {
    return {Mistake::views_equal,
            "both views are " + same + ", which has no disparities; give the left and the right view"};
}

Finding swapped(double agreed, double other_way) {
    return {Mistake::views_swapped, "the views look swapped: both agree on " + percent(agreed) +
                                        " of the picture as given, and on " + percent(other_way) +
                                        " the other way round; exchange --left and --right, of one file by "
                                        "input.stereo.right_first=true, or, if the pair was "
                                        "shifted for a stereo window, give its shift by "
                                        "input.calibration.doffs_px and disparity.min_disparity_px"};
}

std::string rows_text(double px) {
    return figure(std::round(10 * px) / 10);
}

Finding rows_differ(const RowFit& fit) {
    const std::string lower = fit.center_px < 0 ? " higher" : " lower";
    return {Mistake::rows_differ,
            "the views' rows differ: the right view lies " + rows_text(std::fabs(fit.center_px)) + " px" +
                lower + " in the middle, and up to " + rows_text(fit.largest_px) + " px off at a corner (" +
                std::to_string(fit.points) +
                " points); matching looks along rows, so rectify the pair first: --calib stereo.yml "
                "with OpenCV's K1, D1, K2, D2, R and T of these cameras, or --rectify always, by its points"};
}

Finding unrelated(double agreed) {
    return {Mistake::views_unrelated,
            "the pictures look unrelated: both agree on " + percent(agreed) +
                " of the picture only; check that they are the left and right view of one scene, neither "
                "turned nor mirrored"};
}

Finding no_texture(double textured, const char* view) {
    return {Mistake::no_texture, std::string("the ") + view +
                                     " picture is nearly plain: " + percent(textured) +
                                     " of it shows more than noise, and matching needs texture; check the "
                                     "file and its exposure"};
}

Finding begins_high(const LowEnd& low, int min_px) {
    return {Mistake::range_begins_high,
            percent(low.below_share) + " of the points lie below the range searched, which begins at " +
                std::to_string(min_px) + " px: they go down to " + figure(low.least_px) +
                " px and will be wrong; set disparity.min_disparity_px to " +
                std::to_string(static_cast<int>(std::floor(1.1 * low.least_px)) - 2)};
}

std::string name_of(stages::RangeOrigin origin) {
    return origin == stages::RangeOrigin::ndisp ? "the calibration's ndisp" : "disparity.num_disparities_px";
}

std::string advice(stages::RangeOrigin origin, int count) {
    return std::string(origin == stages::RangeOrigin::ndisp
                           ? "correct it, or set disparity.num_disparities_px to "
                           : "set it to ") +
           std::to_string(count) +
           (origin == stages::RangeOrigin::given ? ", or to 0 to have it chosen" : "");
}

Findings check_range(const stages::SmallMatch& coarse, const matching::DisparityRange& range,
                     stages::RangeOrigin origin) {
    if (origin == stages::RangeOrigin::chosen) return {};
    const HighEnd high = measure_high_end(coarse, range.min_px + range.count);
    const double needed = std::max(1.0, high.largest_px - range.min_px + 1);
    const int better = 16 * static_cast<int>(std::ceil((1.06 * needed + 2 * coarse.small.scale) / 16));
    if (high.beyond_share > kMostBeyond)
        return {{Mistake::range_ends_low,
                 percent(high.beyond_share) +
                     " of what both views agree on lies beyond the range searched, " + "which ends at " +
                     std::to_string(range.min_px + range.count) + " px: it goes up to " +
                     figure(high.largest_px) + " px and will be wrong; " + name_of(origin) +
                     " is too small, " + advice(origin, better)}};
    if (high.largest_px > range.min_px && range.count > kWidestRange * needed &&
        range.count > needed + kFreeRange_px)
        return {{Mistake::range_wide, "the range searched is " + figure(range.count / needed) +
                                          " times as wide as the scene's, which ends at " +
                                          figure(high.largest_px) +
                                          " px: that costs time and false matches; " + name_of(origin) +
                                          " is too large, " + advice(origin, better)}};
    return {};
}

// Examines a pair by points anywhere, if its views agree on little, or on much at
// the least disparity searched.
Findings look_closely(const stages::SmallMatch& coarse, double seen_share,
                      const matching::DisparityRange& range, int threads) {
    const double agreed = agreed_share(coarse, seen_share);
    const CoarsePoints points = match_coarse_points(coarse, threads);
    const double scale = coarse.small.scale;
    if (is_sure(points.rows)) {
        const LowEnd low = measure_low_end(points.matches, scale, range.min_px);
        if (range.min_px >= 0 && low.negative_share >= kSwappedBelow)
            if (const double other = swapped_share(coarse, seen_share, threads); other >= kSwappedAgreement)
                return {swapped(agreed, other)};
        if (points.rows.largest_px > kLargestRow_px + kLargestCoarseRow * scale)
            return {rows_differ(points.rows)};
        const int least = static_cast<int>(std::floor(low.least_px / scale)) - 2;
        if (low.below_share > kMostBelow &&
            agreed_share(stages::match_coarsely(coarse.small.pair, least, threads), seen_share) >=
                std::max(agreed, kLeastAgreement))
            return {begins_high(low, range.min_px)};
    }
    if (agreed < kLeastAgreement) return {unrelated(agreed)};
    return {};
}

}  // namespace

std::vector<Finding> check_camera(const Calibration& camera, double median_disparity_px) {
    if (!camera.metric) return {};
    if (camera.baseline_m > kLargestBaseline_m)
        return {{Mistake::baseline_in_mm,
                 "the baseline is " + figure(camera.baseline_m) +
                     " m, which looks like cm or mm: the mesh will be 100 or 1000 times too large; set "
                     "input.calibration.baseline_m to " +
                     figure(camera.baseline_m / 100) + " or " + figure(camera.baseline_m / 1000) +
                     ", or correct the calibration file"}};
    return check_depth(camera, median_disparity_px,
                       "check input.calibration.focal_px (" + figure(camera.focal_px) + ") and baseline_m (" +
                           figure(camera.baseline_m) + ")");
}

std::vector<Finding> check_focal(const Calibration& camera) {
    const int longer_px = std::max(camera.width, camera.height);
    const double view_deg = 360 / std::acos(-1.0) * std::atan(0.5 * longer_px / camera.focal_px);
    if (!(view_deg > kWidestView_deg)) return {};
    return {{Mistake::focal_in_mm,
             "the focal length is " + figure(camera.focal_px) + " px, a view of " + figure(view_deg) +
                 " degrees, which looks like mm; give px, which is mm / the sensor's width in mm * " +
                 std::to_string(camera.width) + ", or --fov-x DEG"}};
}

std::vector<Finding> check_depths(const Calibration& camera, double median_disparity_px) {
    if (!camera.metric) return {};
    return check_depth(camera, median_disparity_px, "check input.depth.unit");
}

Findings check_map(const DisparityMap& map, const Image& left, MapKind kind, const MapScale& stored) {
    Findings findings;
    if (const auto finding = kind == MapKind::depth ? check_depths(map) : check_values(map, stored))
        findings.push_back(*finding);
    if (!left.empty())
        if (const auto finding = check_color(map, left)) findings.push_back(*finding);
    return findings;
}

Findings check_pair(const StereoPair& pair, const stages::SmallMatch& coarse,
                    const matching::DisparityRange& range, stages::RangeOrigin origin, double seen_share,
                    int threads) {
    if (is_blank(pair.left) || is_blank(pair.right)) return {};  // the matcher refuses such a pair
    if (pair.left.channels == pair.right.channels && pair.left.pixels == pair.right.pixels)
        return {views_equal("the same picture")};
    const double left = textured_share(coarse.small.pair.left, threads),
                 right = textured_share(coarse.small.pair.right, threads);
    if (std::min(left, right) < kLeastTexture)
        return {no_texture(std::min(left, right), left <= right ? "left" : "right")};
    if (share_at_zero(coarse) >= kLeastAtZero)
        if (const double share = difference_over_slope(pair); share <= kMostDifference)
            return {views_equal("nearly the same picture (they differ by " + percent(share) +
                                " of what one column to the side would make)")};
    Findings findings;
    if (agreed_share(coarse, seen_share) < kSureAgreement || share_at_low_end(coarse) > kMostAtLowEnd)
        findings = look_closely(coarse, seen_share, range, threads);
    if (findings.empty()) {
        const RowFit rows = measure_rows(pair, coarse, threads);
        if (is_sure(rows) && rows.largest_px > kLargestRow_px) findings.push_back(rows_differ(rows));
    }
    const bool all_wrong = !findings.empty() && findings.front().mistake != Mistake::rows_differ;
    if (!all_wrong)
        for (Finding& finding : check_range(coarse, range, origin)) findings.push_back(std::move(finding));
    return findings;
}

}  // namespace hexrelief::checks
