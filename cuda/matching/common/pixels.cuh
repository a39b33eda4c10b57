// One thread a pixel.
#pragma once

#include <cuda_runtime.h>

#include <cstdint>

#include "pipeline/matching/common/color_step.h"

namespace hexrelief::cuda {

// Blocks of 32x8 pixels: a warp is a run of a row.
inline dim3 pixel_block() {
    return {32, 8, 1};
}
inline dim3 pixel_grid(int width, int height) {
    return {static_cast<unsigned>(width + 31) / 32, static_cast<unsigned>(height + 7) / 8, 1};
}
__device__ inline int2 pixel_of_thread() {
    return {static_cast<int>(blockIdx.x * 32 + threadIdx.x), static_cast<int>(blockIdx.y * 8 + threadIdx.y)};
}

// Where few pixels need much work, a block's threads share those. needs_work(x, y): of each pixel of the
// picture, once; work(x, y): of those for which that is true.
template <typename NeedsWork, typename Work>
__device__ void share_work_of_block(int width, int height, const NeedsWork& needs_work, const Work& work) {
    constexpr unsigned kThreads = 32 * 8;
    __shared__ unsigned count;
    __shared__ std::uint8_t sharing[kThreads];  // whose pixels
    const int2 at = pixel_of_thread();
    const unsigned thread = threadIdx.y * 32 + threadIdx.x;
    if (thread == 0) count = 0;
    __syncthreads();
    if (at.x < width && at.y < height && needs_work(at.x, at.y))
        sharing[atomicAdd(&count, 1u)] = static_cast<std::uint8_t>(thread);
    __syncthreads();
    if (thread >= count) return;
    const int other = sharing[thread];
    work(static_cast<int>(blockIdx.x) * 32 + other % 32, static_cast<int>(blockIdx.y) * 8 + other / 32);
}

HEXRELIEF_HD std::uint8_t channel_of(std::uint32_t color, int channel) {
    return static_cast<std::uint8_t>(color >> (8 * channel));
}

// The largest step::distance of a channel; more, where the fourth bytes differ.
__device__ inline unsigned color_step(std::uint32_t a, std::uint32_t b) {
    const std::uint32_t steps = __vabsdiffu4(a, b);
    return max(max(steps & 0xffu, steps >> 8 & 0xffu), steps >> 16);
}

// Whether color_step() is at most `limit` <= 127, in fewer instructions. The fourth bytes count too.
__device__ inline bool within_color_step(std::uint32_t a, std::uint32_t b, unsigned limit) {
    const std::uint32_t steps = __vabsdiffu4(a, b);
    return ((((steps & 0x7f7f7f7fu) + (127 - limit) * 0x01010101u) | steps) & 0x80808080u) == 0;
}

// Number i of a row, y down, in a picture that repeats its edge.
HEXRELIEF_HD int clamped(int i, int count) {
    return i < 0 ? 0 : i < count ? i : count - 1;
}

}  // namespace hexrelief::cuda
