#include "pipeline/stages/depth.h"

#include <algorithm>
#include <cmath>
#include <iterator>

namespace hexrelief::stages {
namespace {

// Share of the known pixels nearer than the nearest distance; the counterpart of density.scale_percentile.
constexpr double kNearestShare = 0.002;
constexpr double kBaseline = 0.125;  // share of the nearest distance
constexpr double kLargestStep_px = 0.5;

double nearest_distance(const DepthMap& map) {
    std::vector<float> known;
    known.reserve(map.values.size());
    std::copy_if(map.values.begin(), map.values.end(), std::back_inserter(known), DepthMap::known);
    if (known.empty()) return 0;
    return value_at_rank(known, static_cast<std::size_t>(kNearestShare * static_cast<double>(known.size())));
}

}  // namespace

void project_on_axis(DepthMap& map, const Calibration& camera) {
    for (int y = 0; y < map.height; ++y) {
        const double v = (y + 0.5 - camera.cy) / camera.focal_px;
        float* const row = map.values.data() + static_cast<std::size_t>(y) * map.width;
        for (int x = 0; x < map.width; ++x) {
            const double u = (x + 0.5 - camera.cx) / camera.focal_px;
            row[x] = static_cast<float>(row[x] / std::sqrt(1 + u * u + v * v));
        }
    }
}

void keep_between(DepthMap& map, double nearest, double farthest) {
    for (float& depth : map.values)
        if ((nearest > 0 && depth < nearest) || (farthest > 0 && depth > farthest)) depth = kUnknownDepth;
}

double baseline_for(const DepthMap& map, double focal_px) {
    const double nearest = nearest_distance(map);
    const double usual = kBaseline * nearest;
    if (!(map.step > 0) || !(nearest > 0)) return usual;
    const double step_per_m = map.is_inverse ? map.step : map.step / (nearest * nearest);  // as 1 / depth
    return std::min(usual, kLargestStep_px / (focal_px * step_per_m));
}

DisparityMap disparities_of(const DepthMap& map, const Calibration& camera) {
    DisparityMap disparities{map.width, map.height, std::vector<float>(map.values.size(), kUnknownDisparity)};
    const double product = camera.focal_px * camera.baseline_m;
    for (std::size_t i = 0; i < map.values.size(); ++i)
        if (DepthMap::known(map.values[i]))
            disparities.values[i] = static_cast<float>(product / map.values[i] - camera.doffs_px);
    return disparities;
}

}  // namespace hexrelief::stages
