// Measures the noise of a matched map.
#pragma once

#include "pipeline/data/disparity_map.h"

namespace hexrelief::dequantize {

// Maps with less noise are left as they are: their surfaces are smooth, and what is not smooth is detail.
inline constexpr double kLeastNoise_px = 0.07;

// Returns the standard deviation of the noise of a matched map's disparities, px, by the median third
// difference of matches at the distances at which a mesh has its vertices. Third differences vanish on planes
// and on evenly curved surfaces, and the median ignores discontinuities. 0 if hardly anything is matched.
double find_noise_px(const DisparityMap& map);

// Returns the quantum for dequantize() that lets nearly all of the noise be smoothed: a step of as much
// noise.
inline double smoothing_quantum_px(double noise_px) {
    return 7 * noise_px;
}

}  // namespace hexrelief::dequantize
