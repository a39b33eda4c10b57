// Gradient descent to the smoothest surface within half a quantum, on one level.
#pragma once

#include "pipeline/stages/dequantize/pyramid.h"

namespace hexrelief::stages {

// Moves level.smooth towards the minimum of the sum over pixels of
//     xx^2 + yy^2 + 2 xy^2 + pull (smooth - given)^2,   |smooth - given| <= half_px,
// in which xx and yy are the second differences along x and y at pixels that bend, and xy is the mixed
// difference of the square to the right and below at pixels that twist. There are two rounds of four steps,
// whose lengths damp waves of all lengths by Chebyshev's polynomial. Each step reads one map and writes
// another, so the order of pixels does not matter.
void relax(PyramidLevel& level, float pull, float half_px, ThreadPool& pool);

// Does the same with the level's own pulls, without bounds, in as many rounds.
void relax_weighted(PyramidLevel& level, int rounds, ThreadPool& pool);

}  // namespace hexrelief::stages
