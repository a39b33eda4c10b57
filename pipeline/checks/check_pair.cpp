#include "pipeline/checks/check_pair.h"

#include <algorithm>
#include <cmath>

#include "pipeline/checks/pair_statistics.h"
#include "pipeline/checks/thresholds.h"

namespace hexrelief::checks {

namespace {

using Findings = std::vector<Finding>;

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
