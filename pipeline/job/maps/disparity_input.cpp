#include "pipeline/job/maps/disparity_input.h"

#include <algorithm>
#include <cstddef>
#include <iterator>
#include <limits>

#include "pipeline/data/error.h"
#include "pipeline/data/number_text.h"
#include "pipeline/stages/depth.h"

namespace hexrelief::job {
namespace {

// Share of the known disparities beyond infinity that matchers leave by mistake.
constexpr double kFewBeyond = 0.05;
// Largest disparity, as a share of the width, below which an assumed scale of integers is doubted.
constexpr double kSmallest = 0.015, kLargest = 0.6;
constexpr double kStereoSgbm = 16, kAssumed = 256;

constexpr float kLargestFloat = std::numeric_limits<float>::max();

constexpr const char* kAdvice =
    "--disparity-scale -1 turns the sign of all, --disparity-offset PX moves them (input.disparity.scale, "
    "input.disparity.offset_px)";

// Returns the disparity that one in a hundred exceeds.
double usual_largest(const DisparityMap& map) {
    std::vector<float> known;
    std::ranges::copy_if(map.values, std::back_inserter(known), DisparityMap::known);
    if (known.empty()) return 0;
    const auto rank = static_cast<std::ptrdiff_t>(known.size() * 99 / 100);
    std::nth_element(known.begin(), known.begin() + rank, known.end());
    return known[static_cast<std::size_t>(rank)];
}

// Returns the warning of an assumed scale, if the disparities are small and StereoSGBM's scale would be
// usual.
std::vector<std::string> doubts(const DisparityMap& map) {
    const double largest = usual_largest(map), other = largest * kAssumed / kStereoSgbm;
    if (largest >= kSmallest * map.width || other < kSmallest * map.width || other > kLargest * map.width)
        return {};
    return {"the map's disparities go up to " + number_text(largest, 3) +
            " px only, if KITTI's scale of 256 is right, which was assumed; with OpenCV's 1/16 px up to " +
            number_text(other, 3) + " px: give --disparity-scale 16 or 256 (input.disparity.scale)"};
}

// Returns the share of known pixels and their range of depths. Throws Error(input) if none is known.
std::string extent_text(const DepthMap& map) {
    float nearest = kUnknownDepth, farthest = 0;
    std::size_t known = 0;
    for (const float depth : map.values) {
        if (!DepthMap::known(depth)) continue;
        ++known;
        nearest = std::min(nearest, depth);
        farthest = std::max(farthest, depth);
    }
    if (known == 0)
        throw Error(ErrorKind::input,
                    "no depth lies between input.depth.near_m and input.depth.far_m; check them and the "
                    "map's unit (--depth-unit)");
    return number_text(100.0 * static_cast<double>(known) / static_cast<double>(map.values.size()), 4) +
           " % known, " + number_text(nearest, 4) + " to " + number_text(farthest, 4) +
           (map.metric ? " m" : " (relative)");
}

}  // namespace

std::vector<std::string> keep_in_front(readers::DisparityFile& file, double doffs_px) {
    float least = kLargestFloat, largest = -kLargestFloat;
    std::size_t known = 0, beyond = 0;
    for (float& d : file.map.values) {
        if (!DisparityMap::known(d)) continue;
        least = std::min(least, d);
        largest = std::max(largest, d);
        ++known;
        if (d + doffs_px > 0) continue;
        ++beyond;
        d = kUnknownDisparity;
    }
    if (known > 0 && beyond == known)
        throw Error(ErrorKind::input, "the map's disparities go from " + number_text(least, 3) + " to " +
                                          number_text(largest, 3) + " px, none above " +
                                          number_text(0 - doffs_px, 3) + " px, so none has a depth; " +
                                          kAdvice);
    std::vector<std::string> warnings;
    if (file.is_scale_assumed) warnings = doubts(file.map);
    const double share = static_cast<double>(beyond) / static_cast<double>(std::max<std::size_t>(known, 1));
    if (share > kFewBeyond)
        warnings.push_back(number_text(100 * share, 3) + " % of the map's disparities are " +
                           number_text(0 - doffs_px, 3) + " px or less and become unknown; " + kAdvice);
    return warnings;
}

DepthInput take_depths(readers::DepthFile file, const readers::DepthFileConfig& config, bool is_focal_known,
                       Calibration& camera) {
    DepthMap& map = file.map;
    DepthInput input;
    if (config.ray) stages::project_on_axis(map, camera);
    stages::keep_between(map, config.near_m, config.far_m);
    input.decisions.push_back("depth: " + file.believed + "; " + extent_text(map));
    camera.metric = map.metric && is_focal_known;
    if (!(camera.baseline_m > 0) || !map.metric) {
        camera.baseline_m = stages::baseline_for(map, camera.focal_px);
        camera.doffs_px = 0;
        input.is_baseline_chosen = true;
        input.decisions.push_back("depth: taken as disparities of a baseline of " +
                                  number_text(camera.baseline_m, 4) + (map.metric ? " m" : " (relative)") +
                                  ", chosen by the nearest distance");
    }
    input.map = stages::disparities_of(map, camera);
    return input;
}

}  // namespace hexrelief::job
