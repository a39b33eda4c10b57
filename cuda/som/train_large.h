// Trains one level of any size on the device (paper, section 4).
#pragma once

#include "cuda/som/level.h"

namespace hexrelief::cuda {

// Runs these iterations of the level in one persistent kernel; level.points must hold the points of exactly
// these iterations, and level.filled must be 0 everywhere.
void train(const Launch& launch, const LevelView& level, const IterationRange& range);

}  // namespace hexrelief::cuda
