// Finds the step that a map's disparities were rounded to.
#pragma once

#include "pipeline/data/disparity_map.h"

namespace hexrelief::stages {

// Bounds of the step. Finer steps are not visible in any mesh; larger ones are depth discontinuities
// to the surface stage.
inline constexpr double kLeastQuantum_px = 0.1, kLargestQuantum_px = 1;

// Returns the largest step in px of which all known disparities that were not filled (PixelOrigin) are
// multiples, apart from a common offset. Returns 0 if it is outside the bounds, as it is for maps of floats,
// and if all disparities are equal.
double find_quantum_px(const DisparityMap& map);

}  // namespace hexrelief::stages
