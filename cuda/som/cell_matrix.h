// The cellular matrix on the device: the cells' distributions, and points drawn ahead.
#pragma once

#include "cuda/som/level.h"

namespace hexrelief::cuda {

// Cumulative distributions, sums and activities of all cells (Eq. 6 and 7) from the level's density, whose
// maximum largest[0] must hold.
void build_distributions(const Launch& launch, const LevelView& level, const float* density, double delta);

// Draws the points of iterations [first, first + count) into level.points. Points depend on no
// position, so those of many iterations are drawn at once. Their order within an iteration is
// arbitrary; no sum depends on it.
void draw_points(const Launch& launch, const LevelView& level, int first, int count);

}  // namespace hexrelief::cuda
