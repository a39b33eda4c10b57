#include "cuda/matching/sgm/path_pixels.h"

#include "cuda/matching/common/pixels.cuh"

namespace hexrelief::cuda {
namespace {

__global__ void find_path_pixels_kernel(PackedColors left, DisparityView half, int half_min_px,
                                        DisparityRange range, step::PathPenalties penalties,
                                        PathPixels pixels) {
    const int2 at = pixel_of_thread();
    if (at.x >= left.width || at.y >= left.height) return;
    const SearchWindow window =
        range.count <= kSearched ? kWholeWindow : step::find_window(half, half_min_px, range, at.x, at.y);
    const std::uint32_t own = left.at(at.x, at.y), before = left.at(clamped(at.x - 1, left.width), at.y),
                        above = left.at(at.x, clamped(at.y - 1, left.height));
    const std::size_t i = static_cast<std::size_t>(at.y) * left.width + at.x;
    const auto penalty = [&](std::uint32_t other) {
        return step::large_step_penalty(penalties, color_step(own, other));
    };
    pixels.along_rows[i] = path_pixel(penalty(before), window);
    pixels.along_columns[i] = path_pixel(penalty(above), window);
}

}  // namespace

PathPixels take_path_pixels(cudaStream_t stream, Arena& arena, int width, int height) {
    const std::size_t row = static_cast<std::size_t>(width), count = row * height;
    const auto take = [&] {
        PathPixel* const pixels = arena.take<PathPixel>(count + row);
        check(cudaMemsetAsync(pixels + count, 0, row * sizeof(PathPixel), stream), "clearing");
        return pixels;
    };
    return {width, take(), take()};
}

void find_path_pixels(cudaStream_t stream, const PackedColors& left, const RasterView<std::int16_t>& half,
                      const DisparityRange& range, const step::PathPenalties& penalties,
                      const PathPixels& pixels) {
    find_path_pixels_kernel<<<pixel_grid(left.width, left.height), pixel_block(), 0, stream>>>(
        left, reading(half), at_half_size(range).min_px, range, penalties, pixels);
    check_launch("finding penalties and windows");
}

}  // namespace hexrelief::cuda
