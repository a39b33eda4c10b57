#include "cuda/matching/common/pixels.cuh"
#include "cuda/matching/refine/smooth.h"
#include "pipeline/matching/refine/smooth_step.h"

namespace hexrelief::cuda {
namespace {

__device__ step::PlanePoint plane_point(const SmoothInput& in, int x, int y) {
    return {in.map.at(x, y), in.slope_x.at(x, y), in.slope_y.at(x, y)};
}

__global__ void smooth_kernel(SmoothInput in, int stride, DisparityOut out) {
    const int2 at = pixel_of_thread();
    const int width = in.map.width, height = in.map.height;
    if (at.x >= width || at.y >= height) return;
    const step::PlanePoint own = plane_point(in, at.x, at.y);
    const std::uint32_t color = in.colors.at(at.x, at.y);
    std::int32_t offs = 0;
    std::int16_t weights = 0;
#pragma unroll
    for (int j = -step::kSmoothRadius; j <= step::kSmoothRadius; ++j)
#pragma unroll
        for (int i = -step::kSmoothRadius; i <= step::kSmoothRadius; ++i) {
            const int dx = i * stride, dy = j * stride, x = at.x + dx, y = at.y + dy;
            const step::PlanePoint other = plane_point(in, x, y);
            // In the border, whose pixels have no weight, the colour is the edge's.
            const std::uint32_t other_color = in.colors.at(clamped(x, width), clamped(y, height));
            const std::int16_t off =
                step::off_plane(own, other, static_cast<std::int16_t>(dx), static_cast<std::int16_t>(dy));
            const std::int16_t weight = step::smoothing_weight(
                off, step::smoothing_kernel(i, j), color_step(color, other_color), other.disparity);
            offs += std::int32_t{weight} * off;
            weights = static_cast<std::int16_t>(weights + weight);
        }
    out.at(at.x, at.y) = step::smoothed(own.disparity, offs, weights);
}

}  // namespace

void smooth(cudaStream_t stream, const SmoothInput& input, int stride, const DisparityOut& out) {
    smooth_kernel<<<pixel_grid(input.map.width, input.map.height), pixel_block(), 0, stream>>>(input, stride,
                                                                                               out);
    check_launch("smoothing");
}

}  // namespace hexrelief::cuda
