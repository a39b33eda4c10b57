// Reads stereo calibrations.
#pragma once

#include <filesystem>

#include "pipeline/data/calibration.h"

namespace hexrelief {

// Reads a file whose format is recognised by content; metric is true for all of them:
// - Middlebury's calib.txt: cam0, baseline in mm, doffs (else cam1 - cam0), width, height. Stray spaces, CR
//   LF, comments (#) and unknown keys are allowed.
// - KITTI: lines P0..P3 or P_rect_00..03 with 12 numbers, from which focal length, principal point and
//   baseline follow. The colour pair 2, 3 is preferred to 0, 1; the size is that of S_rect where given.
// - OpenCV's FileStorage YAML: Q, else P1 and P2. Lengths are taken as metres; the size is image_width and
//   image_height, or image_size, where given.
// - hexrelief's own keys as YAML: focal_px, baseline_m, cx, cy, doffs_px, width, height. doffs_px is 0 where
//   left out; cx and cy may be left out together where width and height are given, and are then the centre.
// The first three count the centre of pixel 0 as 0, so their principal points are moved by +0.5; hexrelief's
// own keys already count it as 0.5, as Calibration does. Missing width and height are 0 (not said). Throws
// Error(input) naming file and key where something is missing, given twice, not a finite number, or
// impossible (focal or baseline <= 0, pixels not square, a vertical pair).
Calibration read_calibration(const std::filesystem::path& path);

}  // namespace hexrelief
