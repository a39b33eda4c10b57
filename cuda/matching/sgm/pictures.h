// The pair as semi-global matching reads it: colours, census, penalties.
#pragma once

#include "cuda/matching/common/device_raster.h"
#include "pipeline/matching/sgm/path_step.h"

namespace hexrelief::cuda {

struct PairArrays {
    int width, height;
    int channels;                          // of a pixel's cost: 1 or 3
    RasterView<std::uint32_t> colors[2];   // left, right; as PackedColors
    std::uint16_t *penalty_x, *penalty_y;  // of a large step from the pixel to the left, and above
    // Needed until the costs are found.
    RasterView<std::uint64_t> census[2];  // left, right
    RasterView<std::uint8_t> grey[2];     // with a border that repeats the edge
};

// The colours and the penalties, which paths need.
PairArrays take_pair_arrays(cudaStream_t stream, Arena& arena, const DeviceColors& colors, int channels);
// The rest.
void take_cost_arrays(cudaStream_t stream, Arena& arena, PairArrays& arrays);

// half <- an image at half its size (see at_half_size() of pipeline/matching/common).
void halve(cudaStream_t stream, const std::uint8_t* pixels, int width, int height, int channels,
           std::uint8_t* half);

// pixels[i]: image i as it is on the host, with image_channels[i] channels.
void prepare_pair(cudaStream_t stream, const std::uint8_t* const pixels[2], const int image_channels[2],
                  const step::PathPenalties& penalties, const PairArrays& arrays);

}  // namespace hexrelief::cuda
