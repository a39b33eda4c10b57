// Reads stereo calibrations.
#pragma once

#include <filesystem>

#include "pipeline/data/calibration.h"

namespace hexrelief {

// Reads, recognised by content: Middlebury calib.txt (cam0, baseline in mm, doffs, width, height; stray spaces allowed),
// KITTI calib (P0..P3 or P_rect_02/03 lines: focal, principal point and baseline from the projection matrices, colour pair
// P2/P3 preferred), and OpenCV stereo YAML or XML-less FileStorage (Q, or P1 and P2; lengths taken as metres).
// Principal points are turned from "centre of pixel 0 is 0" to "centre of pixel 0 is 0.5" (+0.5).
// Throws Error(input) naming file and key where something is missing, not a number, or impossible (focal or baseline <= 0).
Calibration read_calibration(const std::filesystem::path& path);

}  // namespace hexrelief
