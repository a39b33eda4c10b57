// Checks whether a camera gives depths that a scene can have.
#pragma once

#include <vector>

#include "pipeline/checks/finding.h"
#include "pipeline/data/calibration.h"

namespace hexrelief::checks {

// Checks a metric calibration; others are not judged. median_disparity_px: of the scene; NaN if unknown.
std::vector<Finding> check_camera(const Calibration& camera, double median_disparity_px);
// As check_camera(), for a depth map, whose depths are in metres whatever baseline its
// disparities were made with.
std::vector<Finding> check_depths(const Calibration& camera, double median_disparity_px);

// Checks the angle of view, whether the calibration is metric or not: a focal length in mm is a wide one.
std::vector<Finding> check_focal(const Calibration& camera);

}  // namespace hexrelief::checks
