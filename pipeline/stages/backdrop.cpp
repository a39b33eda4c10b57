#include "pipeline/stages/backdrop.h"

#include <algorithm>
#include <cstddef>
#include <vector>

namespace hexrelief::stages {
namespace {

constexpr float kUnsure_px = 1;  // above the least disparity searched
constexpr double kFarShare = 0.01;
constexpr double kMedians = 10;
constexpr std::size_t kLeastMatches = 100;

std::vector<float> sure_matches(const DisparityMap& map, double least_px) {
    std::vector<float> sure;
    for (std::size_t i = 0; i < map.values.size(); ++i)
        if (map.origins[i] == PixelOrigin::matched && map.values[i] > least_px) sure.push_back(map.values[i]);
    return sure;
}

double quantile(std::vector<float>& values, double share) {
    const auto nth = values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size()));
    std::nth_element(values.begin(), nth, values.end());
    return *nth;
}

}  // namespace

std::optional<Backdrop> put_backdrop(DisparityMap& map, int min_px, double doffs_px, double farthest) {
    // Nothing at or behind infinity has a depth.
    std::vector<float> sure =
        sure_matches(map, std::max(static_cast<double>(min_px) + kUnsure_px, -doffs_px));
    if (sure.size() < kLeastMatches) return std::nullopt;
    const double far = quantile(sure, kFarShare) + doffs_px, median = quantile(sure, 0.5) + doffs_px;
    Backdrop backdrop{static_cast<float>(std::max(far, median / kMedians) / farthest - doffs_px)};
    std::size_t known = 0, moved = 0;
    for (float& d : map.values) {
        if (!DisparityMap::known(d)) continue;
        ++known;
        if (!(d < backdrop.disparity_px)) continue;
        d = backdrop.disparity_px;
        ++moved;
    }
    backdrop.moved_share = static_cast<double>(moved) / static_cast<double>(known);
    return backdrop;
}

}  // namespace hexrelief::stages
