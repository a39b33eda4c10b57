// Stage: from a depth map to the disparities that a stereo camera would see.
#pragma once

#include "pipeline/data/calibration.h"
#include "pipeline/data/depth_map.h"
#include "pipeline/data/disparity_map.h"

namespace hexrelief::stages {

// Converts distances along each pixel's ray to depths along the optical axis.
void project_on_axis(DepthMap& map, const Calibration& camera);

// Makes depths outside [nearest, farthest] unknown; 0 = no limit on that side.
void keep_between(DepthMap& map, double nearest, double farthest);

// Chooses the baseline for a depth map that has none, in the map's unit: an eighth of the nearest distance,
// which is typical of stereo cameras in the scenes that they are made for; the nearest disparity is then
// focal_px / 8. The nearest distance is that which 0.2 % of the known pixels fall short of. The baseline is
// smaller if the map's samples are so coarse that one step would be more than half a pixel there. Depths do
// not depend on the baseline; what depends on it is which neighbours count as one surface, and how exactly
// surfaces are followed. Returns 0 if no pixel is known.
double baseline_for(const DepthMap& map, double focal_px);

// Returns d = focal * baseline / depth - doffs for each pixel. Unknown depths give unknown disparities.
DisparityMap disparities_of(const DepthMap& map, const Calibration& camera);

}  // namespace hexrelief::stages
