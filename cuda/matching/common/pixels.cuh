// Kernels with one thread per pixel, and small functions of pixels.
#pragma once

#include <cuda_runtime.h>

#include <cstdint>

#include "cuda/matching/common/launch.cuh"
#include "pipeline/matching/common/color_step.h"
#include "pipeline/matching/common/halves_step.h"

namespace hexrelief::cuda {

// Returns blocks of 32x8 pixels, in which a warp is a run of a row.
inline Blocks pixel_blocks(int width, int height, unsigned pictures = 1) {
    return {{static_cast<unsigned>(width + 31) / 32, static_cast<unsigned>(height + 7) / 8, pictures},
            {32, 8}};
}
// Returns the pixel (x, y) of the thread.
__device__ inline int2 pixel_of_thread() {
    return {static_cast<int>(blockIdx.x * 32 + threadIdx.x), static_cast<int>(blockIdx.y * 8 + threadIdx.y)};
}

// Kernels keep two 16-bit numbers in a word.
using step::kBoth;

// Returns one channel of a packed colour.
HEXRELIEF_HD std::uint8_t channel_of(std::uint32_t color, int channel) {
    return static_cast<std::uint8_t>(color >> (8 * channel));
}

// Returns the largest step::distance of the three channels; the result may be larger if
// the fourth bytes differ.
__device__ inline unsigned color_step(std::uint32_t a, std::uint32_t b) {
    const std::uint32_t steps = __vabsdiffu4(a, b);
    return max(max(steps & 0xffu, __byte_perm(steps, 0, 0x4441)), steps >> 16);
}

// Returns index i of a row or column of a picture that repeats its edge.
HEXRELIEF_HD int clamped(int i, int count) {
    return i < 0 ? 0 : i < count ? i : count - 1;
}

}  // namespace hexrelief::cuda
