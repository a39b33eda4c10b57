// The cellular self-organizing map of one level on the device.
#pragma once

#include "cuda/som/level.h"

namespace hexrelief::cuda {

// Runs iterations [first, first + count) of the level in one persistent kernel, in batches of prr <=
// kMostBatch; level.points holds just these. first is a multiple of crr. level.filled must be clear.
void train(const Launch& launch, const LevelView& level, int first, int count, int crr, int prr);

}  // namespace hexrelief::cuda
