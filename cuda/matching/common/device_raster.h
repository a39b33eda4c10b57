// Rasters in device memory, as views that kernels take by value.
#pragma once

#include <cstddef>
#include <cstdint>

#include "cuda/common/arena.h"
#include "cuda/common/check.h"
#include "cuda/common/launch.h"
#include "pipeline/matching/common/bordered_raster.h"

namespace hexrelief::cuda {

// Without a border: stride == width.
template <typename T>
matching::RasterView<T> take_plain_raster(Arena& arena, int width, int height) {
    return {arena.take<T>(static_cast<std::size_t>(width) * height), width, height, width};
}

// A row's pixels, and as many more that the next row begins at a whole word of bytes.
inline int in_whole_words(int width) {
    return (width + 3) / 4 * 4;
}

template <typename T>
matching::RasterView<const T> reading(const matching::RasterView<T>& raster) {
    return {raster.origin, raster.width, raster.height, raster.stride};
}

// A pixel's channels as bytes of a word, the first lowest; grey three times.
using PackedColors = matching::RasterView<const std::uint32_t>;

// Of a pair's pictures, as PackedColors.
struct DeviceColors {
    matching::RasterView<std::uint32_t> left, right;
    bool in_color;  // else the three channels are one
};

}  // namespace hexrelief::cuda
