#include "pipeline/checks/check_map.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "pipeline/checks/edge_fit.h"
#include "pipeline/checks/figure_text.h"
#include "pipeline/checks/thresholds.h"

namespace hexrelief::checks {

namespace {

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
                "); give disparities with --disparity, inverse depths with --depth-kind inverse_depth"};
}

Finding values_are_colors(const TurningPoints& turns) {
    return {Mistake::values_are_colors,
            "the map looks like the grey of a colour-mapped picture: " + percent(turns.topmost_share) +
                " of the places where its values turn are folds at the largest one; give the "
                "disparities themselves, "
                "not a picture of them"};
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

bool is_shifted(const AxisFit& fit) {
    return fit.steps >= kLeastSteps && std::abs(fit.best_px) >= kLeastShift_px && fit.best >= kShiftedFit &&
           fit.best - fit.here >= kShiftedGain;
}

std::string shift_text(int px, const char* positive, const char* negative) {
    return std::to_string(std::abs(px)) + " px " + (px > 0 ? positive : negative);
}

Image with_flipped_rows(const Image& image) {
    Image flipped = image;
    const std::size_t row = static_cast<std::size_t>(image.width) * image.channels;
    for (std::size_t y = 0; y < static_cast<std::size_t>(image.height); ++y)
        std::copy_n(image.pixels.begin() + static_cast<std::ptrdiff_t>(y * row), row,
                    flipped.pixels.end() - static_cast<std::ptrdiff_t>((y + 1) * row));
    return flipped;
}

// A map with its rows in the other order fits the picture only if the picture's rows are exchanged, too.
std::optional<Finding> check_rows(const DisparityMap& map, const Image& left, const EdgeFit& fit) {
    const std::optional<double> here = fit_of(fit);
    if (!here || *here >= kLeastFit) return std::nullopt;
    const std::optional<double> flipped = fit_of(measure_edge_fit(map, with_flipped_rows(left)));
    if (!flipped || *flipped < kShiftedFit || *flipped - *here < kShiftedGain) return std::nullopt;
    return Finding{
        Mistake::rows_flipped,
        "the map is upside down against the colour image: the picture's edges fit the map's steps by " +
            figure(*here) + " standard deviations, and by " + figure(*flipped) +
            " with the rows in the other order; --flip exchanges the map's rows"};
}

std::optional<Finding> check_color(const DisparityMap& map, const Image& left) {
    const EdgeFit fit = measure_edge_fit(map, left);
    if (auto flipped = check_rows(map, left, fit)) return flipped;
    const bool columns = is_shifted(fit.columns), rows = is_shifted(fit.rows);
    if (columns || rows)
        return Finding{
            Mistake::color_elsewhere,
            "the colour image is shifted against the map: its edges lie " +
                (columns ? shift_text(fit.columns.best_px, "right of", "left of") : std::string()) +
                (columns && rows ? " and " : "") +
                (rows ? shift_text(fit.rows.best_px, "below", "above") : std::string()) +
                " the map's steps; give the picture of the map's own view, uncropped"};
    const std::optional<double> both = fit_of(fit);
    if (!both || *both >= kLeastFit) return std::nullopt;
    return Finding{
        Mistake::color_unrelated,
        "the colour image does not fit the map: its edges lie at the map's steps no more than at other "
        "places (by " +
            figure(*both) + " standard deviations); check that --color is the left picture, not mirrored"};
}

}  // namespace

Findings check_map(const DisparityMap& map, const Image& left, MapKind kind, const MapScale& stored) {
    Findings findings;
    if (const auto finding = kind == MapKind::depth ? check_depths(map) : check_values(map, stored))
        findings.push_back(*finding);
    if (!left.empty())
        if (const auto finding = check_color(map, left)) findings.push_back(*finding);
    return findings;
}

}  // namespace hexrelief::checks
