// Rasters with a border, so that a window around any pixel can be read without bounds checks, and loops over
// their rows.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "pipeline/base/host_device.h"
#include "pipeline/base/thread_pool.h"

namespace hexrelief::matching {

// Windows reach up to 30 px, and loops round a row's end up to blocks of 32 px.
inline constexpr int kBorder_px = 64;

// A view of a raster: row-major, top row first. at(x, y) may be read for x from -kBorder_px to width +
// kBorder_px - 1, and for y correspondingly.
template <typename T>
struct RasterView {
    T* origin = nullptr;  // pixel (0, 0)
    int width = 0;
    int height = 0;
    int stride = 0;

    HEXRELIEF_HD T* row(int y) const { return origin + static_cast<std::ptrdiff_t>(y) * stride; }
    HEXRELIEF_HD T& at(int x, int y) const { return row(y)[x]; }
};

template <typename T>
class Raster {
  public:
    Raster() = default;
    Raster(int width, int height, T value)
        : width_(width),
          height_(height),
          stride_(width + 2 * kBorder_px),
          values_(static_cast<std::size_t>(stride_) * (height + 2 * kBorder_px), value) {}

    int width() const { return width_; }
    int height() const { return height_; }
    RasterView<T> view() { return {values_.data() + origin(), width_, height_, stride_}; }
    RasterView<const T> view() const { return {values_.data() + origin(), width_, height_, stride_}; }

  private:
    std::size_t origin() const { return static_cast<std::size_t>(kBorder_px) * stride_ + kBorder_px; }

    int width_ = 0, height_ = 0, stride_ = 0;
    std::vector<T> values_;
};

// Disparities in 1/16 px above the least disparity searched. Unknown ones, and the border, are kUnknown16.
using Disparities16 = Raster<std::int16_t>;
using DisparityView = RasterView<const std::int16_t>;
using DisparityOut = RasterView<std::int16_t>;
inline constexpr std::int16_t kUnknown16 = -1;
inline constexpr int kOnePixel = 16;  // 1 px in these units

// The disparities of both views, each at the view's own pixels.
struct ViewDisparities {
    Disparities16 left, right;
};

// The number of pixels of a row that steps with many sums process at a time, so that the sums stay
// in the first-level cache.
inline constexpr int kBlock = 256;

// Runs body(y) for every row, on all threads.
template <typename Body>
void for_each_row(ThreadPool& pool, int height, const Body& body) {
    pool.parallel_for_chunks<8>(static_cast<std::size_t>(height),
                                [&](std::size_t y) { body(static_cast<int>(y)); });
}

}  // namespace hexrelief::matching
