// The pair as semi-global matching reads it: colours and census.
#pragma once

#include "cuda/matching/common/device_raster.h"

namespace hexrelief::cuda {

struct PairArrays {
    int width, height;
    int channels;                         // of a pixel's cost: 1 or 3
    RasterView<std::uint32_t> colors[2];  // left, right; as PackedColors
    RasterView<std::uint64_t> census[2];
    RasterView<std::uint8_t> grey[2];  // with a border that repeats the edge
};

PairArrays take_pair_arrays(cudaStream_t stream, Arena& arena, const DeviceColors& colors, int channels);

// half <- an image at half its size (see at_half_size() of pipeline/matching/common).
void halve(cudaStream_t stream, const std::uint8_t* pixels, int width, int height, int channels,
           std::uint8_t* half);

// pixels[i]: image i as it is on the host, with image_channels[i] channels.
void prepare_pair(cudaStream_t stream, const std::uint8_t* const pixels[2], const int image_channels[2],
                  const PairArrays& arrays);

}  // namespace hexrelief::cuda
