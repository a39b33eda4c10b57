// Weighted medians that line discontinuities up with the picture's colours.
#pragma once

#include "cuda/matching/common/device_raster.h"

namespace hexrelief::cuda {

struct VoteInput {
    DisparityView map, slope_x, slope_y;  // with borders; map without unknown pixels
    PackedColors colors;
    RasterView<const std::int32_t> nearest_seen;
    RasterView<const std::uint8_t> matched;  // origin null: all pixels have one vote, and none is a hole
    int min_px;
};
struct VoteArrays {
    RasterView<std::uint8_t> discontinuous;  // with a border of 0
    std::uint32_t* list;                     // an entry a pixel
    std::uint32_t* count;
};

// voted <- the map with the weighted medians of pixels near discontinuities, and of those not matched.
void take_votes(cudaStream_t stream, const VoteInput& input, const VoteArrays& arrays,
                const DisparityOut& voted);

}  // namespace hexrelief::cuda
