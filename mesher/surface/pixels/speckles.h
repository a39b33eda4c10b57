// Small regions of a disparity map take the disparity of what surrounds them.
#pragma once

#include <cstdint>
#include <vector>

#include "mesher/common/thread_pool.h"
#include "mesher/surface/pixels/discontinuities.h"

namespace hexrelief::surface {

// Both give the disparity of a region's nearest neighbours to its pixels, take all flags from these and
// return them: holes, regions of fewer than cell_px pixels without foreground, which take the least around,
// and speckles, regions of fewer than least_px pixels between the discontinuities in `flags`, which take the
// largest. A map that is one speckle keeps its disparities.
std::vector<std::uint32_t> absorb_holes(PixelSurfaces& surfaces, double cell_px, ThreadPool& pool);
std::vector<std::uint32_t> absorb_speckles(PixelSurfaces& surfaces, int least_px, ThreadPool& pool);

}  // namespace hexrelief::surface
