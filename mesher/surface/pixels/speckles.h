// Small regions of a disparity map take the disparity of what surrounds them.
#pragma once

#include <cstdint>
#include <vector>

#include "mesher/surface/pixels/discontinuities.h"
#include "mesher/common/thread_pool.h"
#include "pipeline/data/disparity_map.h"

namespace hexrelief {

// Both give the disparity of a region's nearest neighbours to its pixels, take all flags from these and
// return them: holes, regions of pixels without foreground, which take the least around, and specks, regions
// of fewer than least_px pixels between the jumps in `flags`, which take the largest. A map that is one speck
// keeps its disparities.
std::vector<std::uint32_t> absorb_holes(PixelSurfaces& surfaces, const DisparityMap& map, double cell_px,
                                        Team& team);
std::vector<std::uint32_t> absorb_specks(PixelSurfaces& surfaces, int least_px, Team& team);

}  // namespace hexrelief
