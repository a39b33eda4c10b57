#include "pipeline/checks/check_camera.h"

#include <algorithm>
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

}  // namespace hexrelief::checks
