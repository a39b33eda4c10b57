// A depth map as the later stages take it: as disparities.
#pragma once

#include <string>
#include <vector>

#include "pipeline/data/calibration.h"
#include "pipeline/data/disparity_map.h"
#include "pipeline/readers/depth/depth_reader.h"

namespace hexrelief::job {

struct DepthInput {
    DisparityMap map;
    std::vector<std::string> decisions;  // what was believed, and which baseline is used
    bool is_baseline_chosen = false;     // by the depths
};

// `camera` is that of the depth map; where its baseline is not known (0), or the depths are relative, it gets
// the one that the map's depths ask for (stages/depth.h). It is metric where the depths are and the focal
// length is known. Throws Error(input) where near_m and far_m leave no depth.
DepthInput take_depths(readers::DepthFile file, const readers::DepthFileConfig& config, bool is_focal_known,
                       Calibration& camera);

}  // namespace hexrelief::job
