// Where a surface is not flat: what linear triangles cannot show.
#pragma once

#include <vector>

#include "pipeline/data/disparity_map.h"

namespace hexrelief::stages {

// The density that a mesh of linear triangles wants on the foreground (>= background_px, above 0), row-major,
// 0..1; 0 elsewhere. A cell of area A over a surface of curvature c is wrong by about c A, so cells that
// share the squared error c^2 A^2 evenly are as dense as c^(2/3). The curvature is
// taken from the residual of a plane that is fitted to a window of some pixels, less the map's own noise and
// up to a bound, which depth discontinuities reach. All 0 where the map consists of planes.
std::vector<float> detail_density(const DisparityMap& map, float background_px);

}  // namespace hexrelief::stages
