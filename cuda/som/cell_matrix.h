// The cellular matrix on the device: the cells' distributions, and points drawn ahead.
#pragma once

#include <cstddef>
#include <cstdint>

#include "cuda/som/level.h"

namespace hexrelief::cuda {

// Computes the cumulative distributions, sums and activities of all cells (Eq. 6 and 7) from the level's
// density, whose maximum must be in largest[0].
void build_distributions(const Launch& launch, const LevelView& level, const float* density, double delta);

// Draws the points of iterations [first, first + count) into level.points. Points do not depend on
// positions, so those of many iterations are drawn together. Their order within an iteration is arbitrary
// and affects no sum.
void draw_points(const Launch& launch, const LevelView& level, int first, int count);

// Densities on the device: sampling weights, and the pyramid of coarser levels.

// Sets largest[0] to the bits of the largest of `count` non-negative floats.
void find_largest(const Launch& launch, const float* values, std::size_t count, std::uint32_t* largest);

// Sets weights to (density / largest)^magnification by a table of kMagnificationSteps + 1 entries; 0 if
// all densities are 0.
void magnify(const Launch& launch, const float* density, std::size_t count, const std::uint32_t* largest,
             const float* table, float* weights);

// Computes the next coarser density, of (width + 1) / 2 x (height + 1) / 2 pixels.
void coarsen(const Launch& launch, const float* fine, int width, int height, float* coarse);

}  // namespace hexrelief::cuda
