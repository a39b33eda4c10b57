#include "pipeline/alignment/disparity_bounds.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "pipeline/alignment/median.h"

namespace hexrelief::alignment {
namespace {

// A toe-in that rows and matches tell may be wrong by so much, whatever the fit says.
constexpr double kLeastYawDeviation = 0.15 * kDegree, kLeastYawDeviationGuessed = 0.3 * kDegree;
// Farthest over nearest distance, at most: if infinity is not known, and if it is.
constexpr double kFarthest = 4, kFarthestKnown = 40;
constexpr double kDeepForWide = 0.25;  // a scene whose infinity is not known: its depth over its width
constexpr std::size_t kNeighbours = 8, kSupporting = 3;
constexpr double kSupport_px = 2, kSupportSlope = 0.1;
constexpr std::size_t kLeastForSupport = 30, kLeastSupported = 20;

// Returns the disparities that at least three of a match's eight nearest have nearly as well: a repeated
// pattern slides along rows unnoticed.
std::vector<double> supported(const std::vector<Match>& matches, const std::vector<double>& disparities) {
    if (matches.size() < kLeastForSupport) return disparities;
    std::vector<std::size_t> order(matches.size());  // by column, so that few are looked at
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::sort(order.begin(), order.end(),
              [&](std::size_t a, std::size_t b) { return matches[a].left.x < matches[b].left.x; });
    std::vector<double> out;
    std::vector<std::pair<double, std::size_t>> nearest;  // a heap of squared distances
    for (std::size_t rank = 0; rank < order.size(); ++rank) {
        const std::size_t i = order[rank];
        const auto column = [&](std::size_t other) { return matches[order[other]].left.x; };
        nearest.clear();
        for (std::size_t before = rank, behind = rank + 1; before > 0 || behind < order.size();) {
            const bool is_before =
                behind == order.size() ||
                (before > 0 && column(rank) - column(before - 1) <= column(behind) - column(rank));
            const std::size_t j = order[is_before ? --before : behind++];
            const double x = matches[j].left.x - matches[i].left.x, y = matches[j].left.y - matches[i].left.y;
            if (nearest.size() == kNeighbours && x * x > nearest.front().first) break;
            nearest.emplace_back(x * x + y * y, j);
            std::push_heap(nearest.begin(), nearest.end());
            if (nearest.size() <= kNeighbours) continue;
            std::pop_heap(nearest.begin(), nearest.end());
            nearest.pop_back();
        }
        const auto agrees = [&](const std::pair<double, std::size_t>& other) {
            return std::fabs(disparities[other.second] - disparities[i]) <
                   kSupport_px + kSupportSlope * std::sqrt(other.first);
        };
        if (static_cast<std::size_t>(std::count_if(nearest.begin(), nearest.end(), agrees)) >= kSupporting)
            out.push_back(disparities[i]);
    }
    return out.size() >= kLeastSupported ? out : disparities;
}

// Returns farthest over nearest distance of a scene that is kDeepForWide times as deep as its far end is
// wide. width: of the picture, in focal lengths.
double farthest_for(double width) {
    const double deep = std::min(kDeepForWide * width, 1 - 1 / kFarthest);
    return 1 / (1 - deep);
}

// unsure_px: how far the disparity of infinity, 0, may be off. width: as above.
DisparityBounds bounds_by(const std::vector<double>& disparities, double unsure_px, double scale,
                          double width) {
    const double low = quantile(disparities, 0.005), high = quantile(disparities, 0.995);
    DisparityBounds bounds;
    bounds.is_infinity_known = low >= unsure_px;
    const double infinity = bounds.is_infinity_known
                                ? std::min(0.0, low - (high - low) / (kFarthestKnown - 1))
                                : low - (high - low) / (farthest_for(width) - 1);
    bounds.least_px = low / scale;
    bounds.largest_px = high / scale;
    bounds.median_px = median(disparities) / scale;
    bounds.infinity_px = infinity / scale;
    return bounds;
}

}  // namespace

DisparityBounds bounds_of(const Estimate& estimate, bool is_focal_known, double scale) {
    const double least = is_focal_known ? kLeastYawDeviation : kLeastYawDeviationGuessed;
    const double unsure_px = 2 * estimate.views().focal_px * std::max(least, estimate.fit.deviations[kYaw]);
    return bounds_by(supported(estimate.agreeing, estimate.disparities()), unsure_px, scale,
                     estimate.camera.width / estimate.views().focal_px);
}

DisparityBounds bounds_as_given(const Estimate& estimate, double scale) {
    std::vector<double> disparities;
    for (const Match& match : estimate.agreeing) disparities.push_back(match.left.x - match.right.x);
    const double unsure_px = 0;  // a rectified pair has its infinity at 0, unless some of it lies behind
    return bounds_by(supported(estimate.agreeing, disparities), unsure_px, scale,
                     estimate.camera.width / estimate.camera.focal_px);
}

Estimate as_given(const Camera& camera, std::vector<Match> matches) {
    Estimate estimate;
    estimate.camera = camera;
    std::vector<double> rows;
    for (const Match& match : matches) {
        const double row = match.right.y - match.left.y;
        if (std::fabs(row) >= kAgreeing_px) continue;
        estimate.agreeing.push_back(match);
        rows.push_back(row);
    }
    estimate.matches = std::move(matches);
    estimate.before = estimate.after = estimate.held_out = row_figures(std::move(rows));
    return estimate;
}

}  // namespace hexrelief::alignment
