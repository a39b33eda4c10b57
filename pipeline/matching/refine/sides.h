// Pixels at discontinuities that another surface's match fits better.
#pragma once

#include "mesher/common/thread_pool.h"
#include "pipeline/matching/common/color_planes.h"

namespace hexrelief::matching {

struct SideInput {
    const Disparities16& map;
    const ColorPlanes &left, &right;  // of as many channels
    const Raster<std::int32_t>& nearest_seen;
    int min_px;
};

// The map, in which pixels beside a discontinuity may have taken a neighbour's disparity.
Disparities16 choose_sides(const SideInput& input, ThreadPool& pool);

}  // namespace hexrelief::matching
