#include "cuda/common/check.h"
#include "cuda/som/density_pyramid.h"
#include "mesher/som/level_transfer_step.h"

namespace hexrelief::cuda {
namespace {

constexpr int kBlock = 256;

// Non-negative floats have the order of their bits, so integer maxima are exact and independent of the order.
__global__ void largest_kernel(const float* values, std::size_t count, std::uint32_t* largest) {
    std::uint32_t best = 0;
    const std::size_t stride = static_cast<std::size_t>(gridDim.x) * blockDim.x;
    for (std::size_t i = blockIdx.x * static_cast<std::size_t>(blockDim.x) + threadIdx.x; i < count;
         i += stride)
        best = max(best, __float_as_uint(values[i]));
    for (int lane = 16; lane > 0; lane /= 2) best = max(best, __shfl_xor_sync(0xFFFFFFFFu, best, lane));
    if (threadIdx.x % 32 == 0 && best > 0) atomicMax(largest, best);
}

__global__ void magnify_kernel(const float* density, std::size_t count, const std::uint32_t* largest,
                               const float* table, float* weights) {
    const float most = __uint_as_float(*largest);
    const std::size_t stride = static_cast<std::size_t>(gridDim.x) * blockDim.x;
    for (std::size_t i = blockIdx.x * static_cast<std::size_t>(blockDim.x) + threadIdx.x; i < count;
         i += stride)
        weights[i] = most > 0 ? step::magnify(density[i] / most, table, som::kMagnificationSteps) : 0.0f;
}

__global__ void coarsen_kernel(const float* fine, int width, int height, float* coarse) {
    const int x = blockIdx.x * blockDim.x + threadIdx.x, y = blockIdx.y * blockDim.y + threadIdx.y;
    const int w = (width + 1) / 2, h = (height + 1) / 2;
    if (x < w && y < h)
        coarse[static_cast<std::size_t>(y) * w + x] = step::coarser_pixel(fine, width, height, x, y);
}

int grid_for(const Launch& launch, std::size_t count) {
    return std::min(blocks_for(count, kBlock), launch.multiprocessors * 16);
}

}  // namespace

void find_largest(const Launch& launch, const float* values, std::size_t count, std::uint32_t* largest) {
    check(cudaMemsetAsync(largest, 0, sizeof *largest, launch.stream), "clearing a maximum");
    largest_kernel<<<grid_for(launch, count), kBlock, 0, launch.stream>>>(values, count, largest);
    check_launch("finding the largest density");
}

void magnify(const Launch& launch, const float* density, std::size_t count, const std::uint32_t* largest,
             const float* table, float* weights) {
    magnify_kernel<<<grid_for(launch, count), kBlock, 0, launch.stream>>>(density, count, largest, table,
                                                                          weights);
    check_launch("magnifying the density");
}

void coarsen(const Launch& launch, const float* fine, int width, int height, float* coarse) {
    const dim3 block(32, 8), grid((width + 1) / 2 / 32 + 1, (height + 1) / 2 / 8 + 1);
    coarsen_kernel<<<grid, block, 0, launch.stream>>>(fine, width, height, coarse);
    check_launch("coarsening the density");
}

}  // namespace hexrelief::cuda
