#include "cuda/matching/common/pixels.cuh"
#include "cuda/matching/sgm/pictures.h"
#include "pipeline/matching/common/half_size_step.h"
#include "pipeline/matching/sgm/cost_step.h"

namespace hexrelief::cuda {
namespace {

__global__ void halve_kernel(const std::uint8_t* __restrict__ pixels, int width, int height, int channels,
                             std::uint8_t* __restrict__ half) {
    const int2 at = pixel_of_thread();
    const int half_width = step::half_size(width);
    if (at.x >= half_width || at.y >= step::half_size(height)) return;
    const std::size_t left = step::first_covered(at.x), right = step::second_covered(at.x, width);
    const std::size_t above = static_cast<std::size_t>(step::first_covered(at.y)) * width,
                      below = static_cast<std::size_t>(step::second_covered(at.y, height)) * width;
    std::uint8_t* const out = half + (static_cast<std::size_t>(at.y) * half_width + at.x) * channels;
    for (int c = 0; c < channels; ++c)
        out[c] =
            step::rounded_mean(pixels[(above + left) * channels + c], pixels[(above + right) * channels + c],
                               pixels[(below + left) * channels + c], pixels[(below + right) * channels + c]);
}

// Also writes the border of grey.
__global__ void split_channels(const std::uint8_t* __restrict__ pixels, int image_channels, bool as_grey,
                               RasterView<std::uint32_t> colors, RasterView<std::uint8_t> grey) {
    const int2 at = pixel_of_thread();
    const int x = at.x - kBorder_px, y = at.y - kBorder_px;
    if (x >= colors.width + kBorder_px || y >= colors.height + kBorder_px) return;
    const std::size_t source =
        static_cast<std::size_t>(clamped(y, colors.height)) * colors.width + clamped(x, colors.width);
    const std::uint8_t* const pixel = pixels + source * image_channels;
    const std::uint8_t luminance =
        image_channels == 3 ? step::luminance(pixel[0], pixel[1], pixel[2]) : pixel[0];
    grey.at(x, y) = luminance;
    if (x < 0 || x >= colors.width || y < 0 || y >= colors.height) return;
    colors.at(x, y) =
        as_grey ? luminance * 0x010101u : pixel[0] | pixel[1] << 8 | static_cast<unsigned>(pixel[2]) << 16;
}

__global__ void find_census(RasterView<const std::uint8_t> grey, RasterView<std::uint64_t> census) {
    const int2 at = pixel_of_thread();
    if (at.x < census.width && at.y < census.height) census.at(at.x, at.y) = step::census(grey, at.x, at.y);
}

}  // namespace

PairArrays take_pair_arrays(cudaStream_t stream, Arena& arena, const DeviceColors& colors, int channels) {
    PairArrays arrays{};
    arrays.width = colors.left.width;
    arrays.height = colors.left.height;
    arrays.channels = channels;
    arrays.colors[0] = colors.left;
    arrays.colors[1] = colors.right;
    for (int i = 0; i < 2; ++i) {
        arrays.census[i] = take_plain_raster<std::uint64_t>(arena, arrays.width, arrays.height);
        arrays.grey[i] = take_raster<std::uint8_t>(stream, arena, arrays.width, arrays.height, 0);
    }
    return arrays;
}

void halve(cudaStream_t stream, const std::uint8_t* pixels, int width, int height, int channels,
           std::uint8_t* half) {
    halve_kernel<<<pixel_grid(step::half_size(width), step::half_size(height)), pixel_block(), 0, stream>>>(
        pixels, width, height, channels, half);
    check_launch("halving a picture");
}

void prepare_pair(cudaStream_t stream, const std::uint8_t* const pixels[2], const int image_channels[2],
                  const PairArrays& arrays) {
    const int width = arrays.width, height = arrays.height;
    const dim3 grid = pixel_grid(width, height),
               bordered = pixel_grid(width + 2 * kBorder_px, height + 2 * kBorder_px);
    for (int i = 0; i < 2; ++i) {
        split_channels<<<bordered, pixel_block(), 0, stream>>>(
            pixels[i], image_channels[i], arrays.channels == 1, arrays.colors[i], arrays.grey[i]);
        check_launch("splitting colours");
        find_census<<<grid, pixel_block(), 0, stream>>>(reading(arrays.grey[i]), arrays.census[i]);
        check_launch("the census transform");
    }
}

}  // namespace hexrelief::cuda
