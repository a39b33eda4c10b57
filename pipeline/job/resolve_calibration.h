// The calibration in effect: a file's, explicit values, or none.
#pragma once

#include <string>
#include <vector>

#include "pipeline/config/config.h"
#include "pipeline/data/calibration.h"

namespace hexrelief {

// Explicit values override the file's. With neither: relative units (focal length = width, baseline 1,
// principal point in the middle), metric = false and one warning. Throws Error(input) where the file's is
// made for another size than width x height, or the principal point lies more than one image size outside the
// image.
Calibration resolve_calibration(const CalibrationConfig& config, int width, int height,
                                std::vector<std::string>& warnings);

}  // namespace hexrelief
