// Measures the noise of a matched map, and decides how it is smoothed.
#pragma once

#include "pipeline/data/disparity_map.h"
#include "pipeline/stages/dequantize/dequantize.h"

namespace hexrelief::stages {

// Bounds of the step. Finer steps are not visible in any mesh; larger ones are depth discontinuities
// to the surface stage.
inline constexpr double kLeastQuantum_px = 0.1, kLargestQuantum_px = 1;

// Returns the largest step in px of which all known disparities that were not filled (PixelOrigin) are
// multiples, apart from a common offset. Returns 0 if it is outside the bounds, as it is for maps of floats,
// and if all disparities are equal.
double find_quantum_px(const DisparityMap& map);

// Maps with less noise are left as they are: their surfaces are smooth, and what is not smooth is detail. A
// relief is a map of which it is not known where infinity lies: its depths are a guess, and its noise shows
// before its detail does.
inline constexpr double kLeastNoise_px = 0.07, kLeastNoiseOfRelief_px = 0.03;

// Returns the standard deviation of the noise of a matched map's disparities, px, by the median third
// difference of matches at the distances at which a mesh has its vertices. Third differences vanish on planes
// and on evenly curved surfaces, and the median ignores discontinuities. 0 if hardly anything is matched.
double find_noise_px(const DisparityMap& map, int threads);

// The argument of dequantize() that lets nearly all of a map's noise be smoothed, if there is at least
// `least_px`.
struct NoiseSmoothing {
    double noise_px = 0;    // 0 = nothing is to be smoothed
    double quantum_px = 0;  // a step of as much noise
};
NoiseSmoothing smoothing_for(double noise_px, double least_px = kLeastNoise_px);

}  // namespace hexrelief::stages
