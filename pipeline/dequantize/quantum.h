// The step that a map's disparities were rounded to.
#pragma once

#include "pipeline/data/disparity_map.h"

namespace hexrelief::dequantize {

// Steps below are finer than any mesh shows; larger ones are depth discontinuities to the surface stage.
inline constexpr double kLeastQuantum_px = 0.1, kLargestQuantum_px = 1;

// The largest step in px of which all known disparities that were not filled (PixelOrigin) are multiples,
// apart from one offset that they share; 0 where it lies outside of these bounds, as it does for maps of
// floats, and where all are equal.
double find_quantum_px(const DisparityMap& map);

}  // namespace hexrelief::dequantize
