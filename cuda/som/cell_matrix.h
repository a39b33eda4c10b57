// The cellular matrix on the device: roulette wheels and the points drawn ahead.
#pragma once

#include "cuda/som/level.h"

namespace hexrelief::cuda {

// Wheels, sums and activities of all cells from the level's density; largest[0] must hold its maximum.
void build_wheels(const Launch& launch, const LevelView& level, const float* density, double delta);

// The points of iterations [first, first + count) into level.points: they depend on no position, so all
// iterations of a batch are drawn at once. Their order within an iteration is arbitrary, which no sum depends
// on.
void draw_points(const Launch& launch, const LevelView& level, int first, int count);

}  // namespace hexrelief::cuda
