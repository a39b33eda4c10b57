// Training of one level on the device (paper, section 4), for levels of any size.
#pragma once

#include "cuda/som/level.h"

namespace hexrelief::cuda {

// Runs these iterations of the level in one persistent kernel; level.points holds the points of just these.
// level.filled must be 0 everywhere.
void train(const Launch& launch, const LevelView& level, const IterationRange& range);

}  // namespace hexrelief::cuda
