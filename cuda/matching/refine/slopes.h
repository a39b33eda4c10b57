// The inclination of the surfaces of a disparity map.
#pragma once

#include "cuda/matching/common/device_raster.h"
#include "pipeline/matching/refine/slopes.h"

namespace hexrelief::cuda {

// With borders.
struct SlopeRasters {
    RasterView<std::int16_t> x, y;
};

// means <- the slopes of map, by way of fitted.
void find_slopes(cudaStream_t stream, const DisparityView& map, const SlopeReach& reach,
                 const SlopeRasters& fitted, const SlopeRasters& means);

}  // namespace hexrelief::cuda
