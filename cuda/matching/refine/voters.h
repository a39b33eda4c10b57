// The weights of pixels as voters in the first round, and the blurred colours for votes in holes.
#pragma once

#include "cuda/matching/common/device_raster.h"
#include "cuda/matching/common/pixel_list.h"

namespace hexrelief::cuda {

struct VoterInput {
    matching::DisparityView map;  // the filled map
    PixelList holes;
    matching::RasterView<const std::int32_t> nearest_seen;
    PackedColors left, right;
    int min_px;
    bool in_color;  // false: the packed colours are grey
};

// Sets `out` to the mean colours of 3x3 pixels.
void blur_colors(cudaStream_t stream, const PackedColors& colors,
                 const matching::RasterView<std::uint32_t>& out);
// Sets the weights of the holes' pixels; all others must be step::kMatchedWeight.
void weigh_voters(cudaStream_t stream, const VoterInput& input,
                  const matching::RasterView<std::uint8_t>& weights);

}  // namespace hexrelief::cuda
