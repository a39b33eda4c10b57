// Which pixels a sparse map's measurements surround.
#pragma once

#include <cstdint>
#include <vector>

#include "pipeline/data/disparity_map.h"
#include "pipeline/densify/measurements.h"

namespace hexrelief::densify {

// How far pixels between measurements are from the nearest one, in px: 90 % of those that have measurements
// on both sides in their row, or in their column, are no farther; of them those do not count that are more
// than four times as far as the median, for they lie in a hole. At least 1.
int typical_distance_px(const DisparityMap& map, const NearestMeasurements& nearest);

// 1 for the pixels that measurements surround or are near to: gaps of up to six typical distances and 8 px
// are closed, and the outermost measurements extended by a typical distance and 2 px, at the picture's edges
// by half a gap. nearest: without colours.
std::vector<std::uint8_t> pixels_to_fill(const DisparityMap& map, const NearestMeasurements& nearest,
                                         int typical_px);

}  // namespace hexrelief::densify
