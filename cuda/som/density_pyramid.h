// Densities on the device: sampling weights, and the pyramid of coarser levels.
#pragma once

#include <cstddef>
#include <cstdint>

#include "cuda/som/level.h"

namespace hexrelief::cuda {

// Sets largest[0] to the bits of the largest of `count` non-negative floats.
void find_largest(const Launch& launch, const float* values, std::size_t count, std::uint32_t* largest);

// Sets weights to (density / largest)^magnification by a table of kMagnificationSteps + 1 entries; 0 if
// all densities are 0.
void magnify(const Launch& launch, const float* density, std::size_t count, const std::uint32_t* largest,
             const float* table, float* weights);

// Computes the next coarser density, of (width + 1) / 2 x (height + 1) / 2 pixels.
void coarsen(const Launch& launch, const float* fine, int width, int height, float* coarse);

}  // namespace hexrelief::cuda
