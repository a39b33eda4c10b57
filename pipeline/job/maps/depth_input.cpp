#include "pipeline/job/maps/depth_input.h"

#include <algorithm>
#include <cstdio>
#include <string>

#include "pipeline/data/error.h"
#include "pipeline/stages/depth.h"

namespace hexrelief::job {
namespace {

std::string number(double value) {
    char text[32];
    std::snprintf(text, sizeof text, "%.4g", value);
    return text;
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
    return number(100.0 * static_cast<double>(known) / static_cast<double>(map.values.size())) +
           " % known, " + number(nearest) + " to " + number(farthest) + (map.metric ? " m" : " (relative)");
}

}  // namespace

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
                                  number(camera.baseline_m) + (map.metric ? " m" : " (relative)") +
                                  ", chosen by the nearest distance");
    }
    input.map = stages::disparities_of(map, camera);
    return input;
}

}  // namespace hexrelief::job
