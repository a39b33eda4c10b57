// The pair as semi-global matching reads it: colours and census.
#pragma once

#include "cuda/matching/common/borders.h"

namespace hexrelief::cuda {

// Left, right: the pictures as they are on the host, both of one size.
struct PairPixels {
    const std::uint8_t* pixels[2];
    int channels[2];
};

struct PairArrays {
    int width, height;
    int channels;                                   // of a pixel's cost: 1 or 3
    matching::RasterView<std::uint32_t> colors[2];  // left, right; as PackedColors
    matching::RasterView<std::uint64_t> census[2];  // without a border; rows are in_whole_words()
    matching::RasterView<std::uint8_t> grey[2];     // with a border that repeats the edge
};

PairArrays take_pair_arrays(Arena& arena, const DeviceColors& colors);

// Both pictures at half their size and on, each half of the one before (see at_half_size() of
// pipeline/matching/common). halved: kMostHalvings at most.
inline constexpr int kMostHalvings = 5;
struct HalvedPixels {
    std::uint8_t* pixels[2];
};
void halve(cudaStream_t stream, const PairPixels& pair, int width, int height,
           const std::vector<HalvedPixels>& halved);

void prepare_pair(cudaStream_t stream, const PairPixels& pair, const PairArrays& arrays);

}  // namespace hexrelief::cuda
