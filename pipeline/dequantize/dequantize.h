// The smoothest disparities that a rounded map can stand for.
#pragma once

#include "pipeline/data/disparity_map.h"

namespace hexrelief::dequantize {

// A map of whole pixels, or of other steps of quantum_px > 0 (find_quantum_px()), has a staircase for each
// slanted surface, which shows as rings when lit. Each disparity moves by less than half a step, to where the
// surface bends least. Nothing is smoothed across depth discontinuities, neighbours more than 1 px apart;
// those of whole pixels remain such. Unknown pixels stay unknown, and disparities of at most half a step stay
// as they are. The same bytes for any number of threads (>= 1).
DisparityMap dequantize(const DisparityMap& map, double quantum_px, int threads);

}  // namespace hexrelief::dequantize
