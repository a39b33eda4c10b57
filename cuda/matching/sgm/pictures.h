// The pair as semi-global matching reads it: colours and census.
#pragma once

#include "cuda/matching/common/borders.h"

namespace hexrelief::cuda {

// Left and right picture as on the host, both of one size.
struct PairPixels {
    const std::uint8_t* pixels[2];
    int channels[2];
};

struct PairArrays {
    int width, height;
    int channels;                                   // channels that count in a pixel's cost: 1 or 3
    matching::RasterView<std::uint32_t> colors[2];  // left, right; as PackedColors
    matching::RasterView<std::uint64_t> census[2];  // without a border; rows are in_whole_words()
    matching::RasterView<std::uint8_t> grey[2];     // with a border that repeats the edge
};

PairArrays take_pair_arrays(Arena& arena, const DeviceColors& colors);

// Halves both pictures repeatedly, each time from the preceding size (see at_half_size() of
// pipeline/matching/common). halved: at most kMostHalvings sizes.
inline constexpr int kMostHalvings = 5;
struct HalvedPixels {
    std::uint8_t* pixels[2];
};
void halve(cudaStream_t stream, const PairPixels& pair, int width, int height,
           const std::vector<HalvedPixels>& halved);

// Makes colours, grey and census of the pictures.
void prepare_pair(cudaStream_t stream, const PairPixels& pair, const PairArrays& arrays);

}  // namespace hexrelief::cuda
