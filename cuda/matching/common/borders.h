// Rasters with a border, whose kernels read windows without bounds tests.
#pragma once

#include <vector>

#include "cuda/matching/common/device_raster.h"

namespace hexrelief::cuda {

// Takes an uninitialised raster with a border of kBorder_px. Rows begin at whole words, so kernels may
// read bytes as words.
template <typename T>
matching::RasterView<T> take_bordered_raster(Arena& arena, int width, int height) {
    const int stride = in_whole_words(width) + 2 * matching::kBorder_px;
    T* const values = arena.take<T>(static_cast<std::size_t>(stride) * (height + 2 * matching::kBorder_px));
    return {values + static_cast<std::size_t>(matching::kBorder_px) * stride + matching::kBorder_px, width,
            height, stride};
}

// A raster's border whose bytes are all set to `byte`.
struct Border {
    std::uint8_t* first_row;
    int pixel_bytes, width, height, stride;
    std::uint8_t byte;

    template <typename T>
    Border(const matching::RasterView<T>& raster, int value)
        : first_row(
              reinterpret_cast<std::uint8_t*>(raster.row(-matching::kBorder_px) - matching::kBorder_px)),
          pixel_bytes(sizeof(T)),
          width(raster.width),
          height(raster.height),
          stride(raster.stride),
          byte(static_cast<std::uint8_t>(value)) {}
    Border() = default;
};

// Fills borders in as few launches as possible, because for a small pair each launch takes as
// long as its work.
void fill_borders(cudaStream_t stream, const std::vector<Border>& borders);

}  // namespace hexrelief::cuda
