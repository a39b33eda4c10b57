// Rasters in device memory, as views that kernels take by value.
#pragma once

#include <cstddef>
#include <cstdint>

#include "cuda/common/arena.h"
#include "cuda/common/check.h"
#include "cuda/common/launch.h"
#include "pipeline/matching/common/bordered_raster.h"

namespace hexrelief::cuda {

// Takes a raster without a border: stride == width.
template <typename T>
matching::RasterView<T> take_plain_raster(Arena& arena, int width, int height) {
    return {arena.take<T>(static_cast<std::size_t>(width) * height), width, height, width};
}

// Returns the width rounded up so that the next row of bytes begins at a whole word.
inline int in_whole_words(int width) {
    return (width + 3) / 4 * 4;
}

// Returns the raster as one of constants.
template <typename T>
matching::RasterView<const T> reading(const matching::RasterView<T>& raster) {
    return {raster.origin, raster.width, raster.height, raster.stride};
}

// A pixel's channels as bytes of a word, the first one lowest; grey repeated three times.
using PackedColors = matching::RasterView<const std::uint32_t>;

// A pair's pictures as PackedColors.
struct DeviceColors {
    matching::RasterView<std::uint32_t> left, right;
    bool in_color;  // false: the three channels are equal
};

}  // namespace hexrelief::cuda
