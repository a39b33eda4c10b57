// Finds the pixels that a sparse map's measurements surround.
#pragma once

#include <cstdint>
#include <vector>

#include "pipeline/data/disparity_map.h"
#include "pipeline/stages/densify/measurements.h"

namespace hexrelief::stages {

// Sets each pixel of a mask of 0 and 1 to `sought` if one of the square of pixels around it is, else to the
// other value.
void spread_square(std::vector<std::uint8_t>& mask, int width, int height, int radius, std::uint8_t sought);

// Returns the 90th percentile, in px, of the distance to the nearest measurement, over unknown pixels that
// have measurements on both sides in their row or column. Distances of more than four times the median are
// ignored, because such pixels lie in a hole. At least 1.
int typical_distance_px(const DisparityMap& map, const NearestMeasurements& nearest);

// Returns 1 for the pixels that measurements surround or are near to, else 0: gaps of up to six typical
// distances and 8 px are closed, and the outermost measurements are extended by a typical distance and 2 px,
// or by half a gap at the picture's edges. nearest: without colours.
std::vector<std::uint8_t> pixels_to_fill(const DisparityMap& map, const NearestMeasurements& nearest,
                                         int typical_px);

}  // namespace hexrelief::stages
