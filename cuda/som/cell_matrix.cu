#include "cuda/som/level.h"

#include "cuda/common/check.h"
#include "mesher/som/cell_matrix_step.h"
#include "mesher/som/level_transfer_step.h"
#include "mesher/som/philox_step.h"

namespace hexrelief::cuda {
namespace {

constexpr int kBlock = 128, kPixelBlock = 256;

// Computes a cell's cumulative distribution by one warp, by prefix sums over 32 pixels at a time. The sums
// are integers, so the result equals that of step::cumulate_weights().
__global__ void cumulative_kernel(LevelView level, const float* density, float full_scale) {
    const int cell = (blockIdx.x * blockDim.x + threadIdx.x) / 32, lane = threadIdx.x % 32;
    if (cell >= level.grid.columns * level.grid.rows) return;
    const float largest = __uint_as_float(level.largest[0]);
    const float scale = full_scale / largest;
    const step::CellBox box = step::cell_box(level.grid, cell);
    const int pixels = box.width * box.height;
    std::uint32_t sum = 0;
    for (int first = 0; first < pixels; first += 32) {
        const int i = first + lane;
        std::uint32_t weight = 0;
        if (i < pixels && largest > 0) {
            const int x = box.x0 + i % box.width, y = box.y0 + i / box.width;
            weight =
                step::quantise_weight(density[static_cast<std::size_t>(y) * level.grid.width + x], scale);
        }
        for (int step = 1; step < 32; step *= 2) {
            const std::uint32_t before = __shfl_up_sync(0xFFFFFFFFu, weight, step);
            if (lane >= step) weight += before;
        }
        if (i < pixels) level.cumulative[box.offset + i] = sum + weight;
        sum += __shfl_sync(0xFFFFFFFFu, weight, 31);
    }
    if (lane != 0) return;
    level.sums[cell] = sum;
    atomicMax(&level.largest[1], sum);
}

__global__ void activity_kernel(LevelView level, double delta) {
    const int cell = blockIdx.x * blockDim.x + threadIdx.x;
    if (cell >= level.grid.columns * level.grid.rows) return;
    const std::uint32_t most = level.largest[1];
    level.activity[cell] = most ? step::cell_activity(level.sums[cell], most, delta) : 0;
    level.filled[cell] = 0;
}

__global__ void draw_kernel(LevelView level, int first) {
    const int cell = blockIdx.x * blockDim.x + threadIdx.x, slot = blockIdx.y;
    if (cell >= level.grid.columns * level.grid.rows) return;
    const std::uint64_t activity = level.activity[cell];
    if (!activity) return;
    const int iteration = first + slot;
    step::Random4 random = step::philox(level.seed, cell, iteration, level.level, 0);
    const int count = step::draw_count(activity, random.word[0]);
    if (!count) return;
    std::uint32_t at = atomicAdd(&level.point_count[slot], static_cast<std::uint32_t>(count));
    std::uint32_t* const points = level.points + static_cast<std::size_t>(slot) * level.point_capacity;
    for (int k = 0; k < count; ++k) {
        const int word = k + 1;
        if (word % 4 == 0) random = step::philox(level.seed, cell, iteration, level.level, word / 4);
        const step::HalfPoint point = step::extract_point(
            level.grid, cell, level.cumulative, level.sums[cell], {k, count, random.word[word % 4]});
        points[at++] = static_cast<std::uint32_t>(point.x) | static_cast<std::uint32_t>(point.y) << 16;
    }
}

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
    return std::min(blocks_for(count, kPixelBlock), launch.multiprocessors * 16);
}

}  // namespace

void build_distributions(const Launch& launch, const LevelView& level, const float* density, double delta) {
    const int cells = level.grid.columns * level.grid.rows;
    check(cudaMemsetAsync(&level.largest[1], 0, sizeof(std::uint32_t), launch.stream), "clearing a maximum");
    const float full_scale = static_cast<float>((1u << step::weight_bits(level.grid.co)) - 1);
    cumulative_kernel<<<blocks_for(static_cast<std::size_t>(cells) * 32, kBlock), kBlock, 0, launch.stream>>>(
        level, density, full_scale);
    activity_kernel<<<blocks_for(cells, kBlock), kBlock, 0, launch.stream>>>(level, delta);
    check_launch("building the cells' distributions");
}

void draw_points(const Launch& launch, const LevelView& level, int first, int count) {
    check(cudaMemsetAsync(level.point_count, 0, count * sizeof(std::uint32_t), launch.stream),
          "clearing the point counts");
    const int cells = level.grid.columns * level.grid.rows;
    draw_kernel<<<dim3(blocks_for(cells, kBlock), count), kBlock, 0, launch.stream>>>(level, first);
    check_launch("drawing points");
}

void find_largest(const Launch& launch, const float* values, std::size_t count, std::uint32_t* largest) {
    check(cudaMemsetAsync(largest, 0, sizeof *largest, launch.stream), "clearing a maximum");
    largest_kernel<<<grid_for(launch, count), kPixelBlock, 0, launch.stream>>>(values, count, largest);
    check_launch("finding the largest density");
}

void magnify(const Launch& launch, const float* density, std::size_t count, const std::uint32_t* largest,
             const float* table, float* weights) {
    magnify_kernel<<<grid_for(launch, count), kPixelBlock, 0, launch.stream>>>(density, count, largest, table,
                                                                               weights);
    check_launch("magnifying the density");
}

void coarsen(const Launch& launch, const float* fine, int width, int height, float* coarse) {
    const dim3 block(32, 8), grid((width + 1) / 2 / 32 + 1, (height + 1) / 2 / 8 + 1);
    coarsen_kernel<<<grid, block, 0, launch.stream>>>(fine, width, height, coarse);
    check_launch("coarsening the density");
}

}  // namespace hexrelief::cuda
