// The cellular self-organizing map of one level on the device.
#pragma once

#include "cuda/level.h"

namespace hexrelief::cuda {

// Runs iterations [first, first + count) of the level in one persistent kernel, in batches of prr <=
// kMostPrr; draw_points must have filled level.points for just these. first is a multiple of crr. level.units
// and level.filled must be clear at first = 0.
void train(const Launch& launch, const LevelView& level, int first, int count, int crr, int prr);

}  // namespace hexrelief::cuda
