#include "cuda/matching/sgm/volume.h"

#include "cuda/matching/common/pixels.cuh"
#include "pipeline/matching/common/color_step.h"

namespace hexrelief::cuda {
namespace {

// A thread handles the pixels of one pixel at half size, which have the same window.
__global__ void find_path_pixels_kernel(PackedColors left, matching::DisparityView half, int half_min_px,
                                        matching::DisparityRange range, step::PathPenalties penalties,
                                        PathPixels pixels) {
    begin_kernel();
    const int2 at = pixel_of_thread();
    if (at.x >= step::half_size(left.width) || at.y >= step::half_size(left.height)) return;
    const PathPixel window = path_pixel(0, matching::is_searched_wholly(range)
                                               ? matching::kWholeWindow
                                               : step::find_window(half, half_min_px, range, at.x, at.y));
    const int x[3] = {clamped(2 * at.x - 1, left.width), 2 * at.x, clamped(2 * at.x + 1, left.width)},
              y[3] = {clamped(2 * at.y - 1, left.height), 2 * at.y, clamped(2 * at.y + 1, left.height)};
    std::uint32_t colors[3][3];
#pragma unroll
    for (int j = 0; j < 3; ++j)
#pragma unroll
        for (int i = 0; i < 3; ++i) colors[j][i] = left.at(x[i], y[j]);
#pragma unroll
    for (int j = 1; j < 3; ++j)
#pragma unroll
        for (int i = 1; i < 3; ++i) {
            if ((i == 2 && x[2] == x[1]) || (j == 2 && y[2] == y[1])) continue;
            const std::size_t pixel = static_cast<std::size_t>(y[j]) * left.width + x[i];
            const auto with_penalty = [&](std::uint32_t other) {
                const auto step = static_cast<int>(color_step(colors[j][i], other));
                return window | step::large_step_penalty(penalties, step);
            };
            pixels.along_rows[pixel] = with_penalty(colors[j][i - 1]);
            pixels.along_columns[pixel] = with_penalty(colors[j - 1][i]);
            if (y[j] == left.height - 1)
                pixels.along_rows[pixel + left.width] = pixels.along_columns[pixel + left.width] = 0;
        }
}

}  // namespace

PathPixels take_path_pixels(Arena& arena, int width, int height) {
    const std::size_t row = static_cast<std::size_t>(width), count = row * height;
    const auto take = [&] { return arena.take<PathPixel>(count + row); };
    return {width, take(), take()};
}

void find_path_pixels(cudaStream_t stream, const PackedColors& left,
                      const matching::RasterView<std::int16_t>& half, const matching::DisparityRange& range,
                      const step::PathPenalties& penalties, const PathPixels& pixels) {
    const Blocks blocks = pixel_blocks(step::half_size(left.width), step::half_size(left.height));
    launch("finding penalties and windows", stream, blocks, find_path_pixels_kernel, left, reading(half),
           matching::at_half_size(range).min_px, range, penalties, pixels);
}

}  // namespace hexrelief::cuda
