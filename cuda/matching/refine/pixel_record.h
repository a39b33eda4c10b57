// The data that voting and smoothing read of a pixel, in one access of 16 bytes each.
#pragma once

#include <cstdint>

#include "cuda/matching/common/device_raster.h"

namespace hexrelief::cuda {

// A pixel for voting. Colours are PackedColors; their fourth byte is kNoColor if the disparity is unknown, so
// that the pixel resembles no other. All bits of the border's records are set: unknown, and of no colour.
struct alignas(16) PixelRecord {
    std::int16_t disparity;
    std::uint16_t vote_weight;  // weight of the pixel as a voter
    std::uint32_t slopes;       // along x in the lower half, along y in the upper half
    std::uint32_t color;
    std::uint32_t hole_color;  // blurred, for votes in holes
};
inline constexpr std::uint32_t kNoColor = 0xff000000u;

using PixelRecords = matching::RasterView<const PixelRecord>;

// A pixel for smoothing. All bits of the colour are set if the disparity is unknown, and in the border.
struct alignas(16) PlaneRecord {
    std::int32_t disparity;  // 1/16 px
    std::uint32_t slopes;    // see PixelRecord
    std::uint32_t color;     // see step::PlaneColor
    std::uint32_t unused;
};
using PlaneRecords = matching::RasterView<const PlaneRecord>;

}  // namespace hexrelief::cuda
