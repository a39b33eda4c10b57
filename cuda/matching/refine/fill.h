// Unknown pixels filled from the matches around them.
#pragma once

#include "cuda/matching/common/device_raster.h"
#include "cuda/matching/refine/slopes.h"
#include "pipeline/matching/refine/fill_step.h"

namespace hexrelief::cuda {

// By direction and pixel: how far the nearest known pixel is, 0 = there is none.
struct FillArrays {
    std::uint16_t* distances[step::kDirections];
};
struct FillInput {
    DisparityView map, right;  // trusted matches of both views
    PixelRecords records;      // of map
    RasterView<const std::int32_t> nearest_seen;
    PackedColors left_colors, right_colors;
    int min_px;
};

// Sets arrays.
void find_known(cudaStream_t stream, const DisparityView& map, const FillArrays& arrays);
// filled <- input.map with its unknown pixels filled.
void fill_unknown(cudaStream_t stream, const FillInput& input, const FillArrays& arrays,
                  const DisparityOut& filled);

}  // namespace hexrelief::cuda
