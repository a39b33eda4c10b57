#include "pipeline/checks/check_camera.h"

#include <cmath>

#include "pipeline/checks/figure_text.h"
#include "pipeline/checks/thresholds.h"

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

}  // namespace

std::vector<Finding> check_camera(const Calibration& camera, double median_disparity_px) {
    if (!camera.metric) return {};
    if (camera.baseline_m > kLargestBaseline_m)
        return {{Mistake::baseline_in_mm,
                 "the baseline is " + figure(camera.baseline_m) +
                     " m, which looks like millimetres: the mesh will be 1000 times too large; set "
                     "input.calibration.baseline_m to " +
                     figure(camera.baseline_m / 1000) + ", or correct the calibration file"}};
    return check_depth(camera, median_disparity_px,
                       "check input.calibration.focal_px (" + figure(camera.focal_px) + ") and baseline_m (" +
                           figure(camera.baseline_m) + ")");
}

std::vector<Finding> check_depths(const Calibration& camera, double median_disparity_px) {
    if (!camera.metric) return {};
    return check_depth(camera, median_disparity_px, "check input.depth.unit");
}

}  // namespace hexrelief::checks
