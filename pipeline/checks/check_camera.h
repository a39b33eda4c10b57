// Are the depths those of a scene?
#pragma once

#include <vector>

#include "pipeline/checks/finding.h"
#include "pipeline/data/calibration.h"

namespace hexrelief::checks {

// median_disparity_px: of the scene; NaN where it is not known. Judges only metric calibrations.
std::vector<Finding> check_camera(const Calibration& camera, double median_disparity_px);
// Of a depth map, whose depths are in metres whatever the baseline that its disparities were made with.
std::vector<Finding> check_depths(const Calibration& camera, double median_disparity_px);

}  // namespace hexrelief::checks
