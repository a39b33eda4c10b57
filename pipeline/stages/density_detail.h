// The density that curved surfaces need, because linear triangles cannot represent them.
#pragma once

#include <vector>

#include "pipeline/data/disparity_map.h"

namespace hexrelief::stages {

// Returns the density that a mesh of linear triangles needs on the foreground (disparities >= background_px
// and above 0), row-major, 0..1; 0 elsewhere. A cell of area A over a surface of curvature c has an error of
// about c A, so the cells share the squared error c^2 A^2 evenly if their density is c^(2/3). The curvature
// is the residual of a plane fitted to a window of some pixels, less the map's own noise, and capped; depth
// discontinuities reach the cap. All values are 0 if the map consists of planes.
std::vector<float> detail_density(const DisparityMap& map, float background_px);

}  // namespace hexrelief::stages
