// Stage: depth map -> the disparities that a stereo camera of some baseline would see.
#pragma once

#include "pipeline/data/calibration.h"
#include "pipeline/data/depth_map.h"
#include "pipeline/data/disparity_map.h"

namespace hexrelief::stages {

// Distances along each pixel's ray become distances along the optical axis.
void project_on_axis(DepthMap& map, const Calibration& camera);

// Depths outside of [nearest, farthest] become unknown; 0 = no limit on that side.
void keep_between(DepthMap& map, double nearest, double farthest);

// The baseline that a map without one is given, in the map's unit: an eighth of the nearest distance (which
// 0.2 % of the known pixels fall short of), as stereo cameras have it for the scenes that they are made for;
// the nearest disparity is then focal_px / 8. Smaller where the map's samples are so coarse that one step
// would be more than half a pixel there. Depths do not depend on it; what does is which neighbours count as
// one surface, and how exactly surfaces are followed. 0 where no pixel is known.
double baseline_for(const DepthMap& map, double focal_px);

// d = focal * baseline / depth - doffs. Unknown stays unknown.
DisparityMap disparities_of(const DepthMap& map, const Calibration& camera);

}  // namespace hexrelief::stages
