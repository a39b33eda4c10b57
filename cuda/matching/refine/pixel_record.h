// What voting and smoothing read of a pixel, in one access of 16 bytes.
#pragma once

#include <cstdint>

#include "cuda/matching/common/device_raster.h"

namespace hexrelief::cuda {

struct alignas(16) PixelRecord {
    std::int16_t disparity;  // kUnknown16 in the border
    std::int16_t slope_x, slope_y;
    std::uint16_t vote_weight;  // of the pixel as a voter
    std::uint32_t color;        // as PackedColors
    std::uint32_t hole_color;   // blurred, for votes in holes
};

using PixelRecords = RasterView<const PixelRecord>;

}  // namespace hexrelief::cuda
