// The smoothest surface within half a quantum: steps of gradient descent on one level.
#pragma once

#include "pipeline/dequantize/pyramid.h"

namespace hexrelief::dequantize {

// Brings level.smooth closer to the least sum over pixels of
//     xx^2 + yy^2 + 2 xy^2 + pull (smooth - given)^2,   |smooth - given| <= half_px,
// where xx and yy are the second differences along x and y where a pixel bends, and xy is that of the square
// to the right and below where it twists. Two rounds of four steps, whose lengths damp waves of all lengths
// by Chebyshev's polynomial; each reads one map and writes another, so no order of pixels matters.
void relax(PyramidLevel& level, float pull, float half_px, ThreadPool& pool);

}  // namespace hexrelief::dequantize
