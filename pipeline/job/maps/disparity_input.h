// Makes disparities that have no depth unknown, and looks at the scale that was assumed.
#pragma once

#include <string>
#include <vector>

#include "pipeline/data/calibration.h"
#include "pipeline/data/disparity_map.h"
#include "pipeline/readers/depth/depth_reader.h"
#include "pipeline/readers/disparity_reader.h"

namespace hexrelief::job {

// Makes disparities unknown that do not lie in front of infinity, which is at -doffs_px. Returns warnings: of
// a sign that may be turned, and of an assumed scale that makes all disparities small. Throws Error(input) if
// no disparity remains.
std::vector<std::string> keep_in_front(readers::DisparityFile& file, double doffs_px);

struct DepthInput {
    DisparityMap map;
    std::vector<std::string> decisions;  // how the samples were read, and a baseline that was chosen
    bool is_baseline_chosen = false;     // true if the depths chose the baseline
};

// Converts depths to disparities. `camera` is the depth map's; if its baseline is unknown (0), or the depths
// are relative, the baseline is chosen by the depths (stages/depth.h). The camera becomes metric if the
// depths are and the focal length is known. Throws Error(input) if near_m and far_m leave no depth.
DepthInput take_depths(readers::DepthFile file, const readers::DepthFileConfig& config, bool is_focal_known,
                       Calibration& camera);

}  // namespace hexrelief::job
