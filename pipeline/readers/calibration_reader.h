// Reads stereo calibrations.
#pragma once

#include <filesystem>

#include "pipeline/data/calibration.h"

namespace hexrelief {

// Reads, recognised by content (metric is true for all of them):
// - Middlebury calib.txt: cam0, baseline in mm, doffs (else cam1 - cam0), width, height; stray spaces, CR LF,
// comments (#)
//   and unknown keys allowed.
// - KITTI: lines P0..P3 or P_rect_00..03 with 12 numbers: focal, principal point and baseline from the
// projection
//   matrices, the colour pair 2, 3 preferred to 0, 1; size from S_rect where given.
// - OpenCV FileStorage YAML: Q, else P1 and P2; lengths taken as metres; size from image_width and
// image_height or
//   image_size where given.
// - hexrelief's own keys as YAML: focal_px, baseline_m, cx, cy, doffs_px, width, height. doffs_px is 0 where
// left out; cx and
//   cy may be left out together where width and height are given, and are then the centre.
// The first three count the centre of pixel 0 as 0, so their principal points are moved by +0.5; hexrelief's
// own keys already count it as 0.5, as Calibration does. Missing width and height are 0 (not said). Throws
// Error(input) naming file and key where something is missing, given twice, not a finite number, or
// impossible (focal or baseline <= 0, pixels not square, a vertical pair).
Calibration read_calibration(const std::filesystem::path& path);

}  // namespace hexrelief
