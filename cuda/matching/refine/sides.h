// Moves pixels at discontinuities to the surface whose match fits better.
#pragma once

#include "cuda/matching/common/device_raster.h"

namespace hexrelief::cuda {

struct SideInput {
    matching::DisparityView map;
    PackedColors left, right;
    matching::RasterView<const std::int32_t> nearest_seen;
    int min_px;
};

// Sets `chosen` to the map, in which pixels beside a discontinuity may have taken a neighbour's disparity.
void choose_sides(cudaStream_t stream, const SideInput& input, const matching::DisparityOut& chosen);

}  // namespace hexrelief::cuda
