#include "cuda/matching/sgm/path_pixels.h"

#include "cuda/matching/common/pixels.cuh"
#include "pipeline/matching/common/half_size_step.h"

namespace hexrelief::cuda {
namespace {

// A thread takes the pixels of one at half size: their windows are the same.
__global__ void find_path_pixels_kernel(PackedColors left, DisparityView half, int half_min_px,
                                        DisparityRange range, step::PathPenalties penalties,
                                        PathPixels pixels) {
    begin_kernel();
    const int2 at = pixel_of_thread();
    if (at.x >= step::half_size(left.width) || at.y >= step::half_size(left.height)) return;
    const SearchWindow window =
        is_searched_wholly(range) ? kWholeWindow : step::find_window(half, half_min_px, range, at.x, at.y);
    const int first_x = step::first_covered(at.x), last_x = step::second_covered(at.x, left.width);
    const int first_y = step::first_covered(at.y), last_y = step::second_covered(at.y, left.height);
    for (int y = first_y; y <= last_y; ++y)
        for (int x = first_x; x <= last_x; ++x) {
            const std::uint32_t own = left.at(x, y), before = left.at(clamped(x - 1, left.width), y),
                                above = left.at(x, clamped(y - 1, left.height));
            const std::size_t i = static_cast<std::size_t>(y) * left.width + x;
            const auto penalty = [&](std::uint32_t other) {
                return step::large_step_penalty(penalties, static_cast<int>(color_step(own, other)));
            };
            pixels.along_rows[i] = path_pixel(penalty(before), window);
            pixels.along_columns[i] = path_pixel(penalty(above), window);
            if (y == left.height - 1)
                pixels.along_rows[i + left.width] = pixels.along_columns[i + left.width] = 0;
        }
}

}  // namespace

PathPixels take_path_pixels(Arena& arena, int width, int height) {
    const std::size_t row = static_cast<std::size_t>(width), count = row * height;
    const auto take = [&] { return arena.take<PathPixel>(count + row); };
    return {width, take(), take()};
}

void find_path_pixels(cudaStream_t stream, const PackedColors& left, const RasterView<std::int16_t>& half,
                      const DisparityRange& range, const step::PathPenalties& penalties,
                      const PathPixels& pixels) {
    const Blocks blocks = pixel_blocks(step::half_size(left.width), step::half_size(left.height));
    launch("finding penalties and windows", stream, blocks, find_path_pixels_kernel, left, reading(half),
           at_half_size(range).min_px, range, penalties, pixels);
}

}  // namespace hexrelief::cuda
