// The cellular matrix on the device: the cells' distributions, and points drawn ahead.
#pragma once

#include "cuda/som/level.h"

namespace hexrelief::cuda {

// Computes the cumulative distributions, sums and activities of all cells (Eq. 6 and 7) from the level's
// density, whose maximum must be in largest[0].
void build_distributions(const Launch& launch, const LevelView& level, const float* density, double delta);

// Draws the points of iterations [first, first + count) into level.points. Points do not depend on
// positions, so those of many iterations are drawn together. Their order within an iteration is arbitrary
// and affects no sum.
void draw_points(const Launch& launch, const LevelView& level, int first, int count);

}  // namespace hexrelief::cuda
