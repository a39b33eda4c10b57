// Surfaces without the lumps that matching leaves.
#pragma once

#include "cuda/matching/common/device_raster.h"

namespace hexrelief::cuda {

struct SmoothInput {
    DisparityView map, slope_x, slope_y;  // with borders
    PackedColors colors;
};

// out <- one level of 5x5 pixels, `stride` px apart.
void smooth(cudaStream_t stream, const SmoothInput& input, int stride, const DisparityOut& out);

}  // namespace hexrelief::cuda
