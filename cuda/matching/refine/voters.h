// What pixels weigh as voters in the first round.
#pragma once

#include "cuda/matching/common/device_raster.h"
#include "cuda/matching/common/pixel_list.h"

namespace hexrelief::cuda {

struct VoterInput {
    DisparityView map;  // filled
    PixelList holes;
    RasterView<const std::int32_t> nearest_seen;
    PackedColors left, right;
    int min_px;
    bool in_color;  // else the packed colours are grey
};

// Sets those of holes; the others' are step::kMatchedWeight.
void weigh_voters(cudaStream_t stream, const VoterInput& input, const RasterView<std::uint8_t>& weights);

}  // namespace hexrelief::cuda
