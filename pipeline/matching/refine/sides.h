// Corrects pixels at discontinuities that match better on the neighbouring surface.
#pragma once

#include "pipeline/base/thread_pool.h"
#include "pipeline/matching/common/color_planes.h"

namespace hexrelief::matching {

struct SideInput {
    const Disparities16& map;
    const ColorPlanes &left, &right;  // with equal numbers of channels
    const Raster<std::int32_t>& nearest_seen;
    int min_px;
};

// Returns the map, in which pixels beside a discontinuity may have taken a neighbour's disparity.
Disparities16 choose_sides(const SideInput& input, ThreadPool& pool);

}  // namespace hexrelief::matching
