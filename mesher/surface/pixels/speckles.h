// Merges small regions of a disparity map into their surroundings.
#pragma once

#include <cstdint>
#include <vector>

#include "mesher/surface/pixels/discontinuities.h"
#include "pipeline/base/thread_pool.h"

namespace hexrelief::surface {

// Fills the holes, regions of fewer than cell_px pixels without foreground, with the smallest disparity
// around them, ring by ring from their border inwards. Clears the flags of their pixels and returns these.
std::vector<std::uint32_t> absorb_holes(PixelSurfaces& surfaces, double cell_px, ThreadPool& pool);
// Gives speckles, regions of fewer than least_px pixels between the discontinuities in `flags`, the largest
// disparity around them in the same way. A map that is a single speckle keeps its disparities.
std::vector<std::uint32_t> absorb_speckles(PixelSurfaces& surfaces, int least_px, ThreadPool& pool);

}  // namespace hexrelief::surface
