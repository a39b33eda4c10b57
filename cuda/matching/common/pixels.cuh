// One thread a pixel.
#pragma once

#include <cuda_runtime.h>

#include <cstdint>

#include "cuda/matching/common/launch.cuh"
#include "pipeline/matching/common/color_step.h"
#include "pipeline/matching/common/halves_step.h"

namespace hexrelief::cuda {

// Blocks of 32x8 pixels: a warp is a run of a row.
inline Blocks pixel_blocks(int width, int height, unsigned pictures = 1) {
    return {{static_cast<unsigned>(width + 31) / 32, static_cast<unsigned>(height + 7) / 8, pictures},
            {32, 8}};
}
__device__ inline int2 pixel_of_thread() {
    return {static_cast<int>(blockIdx.x * 32 + threadIdx.x), static_cast<int>(blockIdx.y * 8 + threadIdx.y)};
}

// Kernels keep two numbers of 16 bits in a word.
using step::kBoth;

HEXRELIEF_HD std::uint8_t channel_of(std::uint32_t color, int channel) {
    return static_cast<std::uint8_t>(color >> (8 * channel));
}

// The largest step::distance of a channel; more, where the fourth bytes differ.
__device__ inline unsigned color_step(std::uint32_t a, std::uint32_t b) {
    const std::uint32_t steps = __vabsdiffu4(a, b);
    return max(max(steps & 0xffu, __byte_perm(steps, 0, 0x4441)), steps >> 16);
}

// Number i of a row, y down, in a picture that repeats its edge.
HEXRELIEF_HD int clamped(int i, int count) {
    return i < 0 ? 0 : i < count ? i : count - 1;
}

}  // namespace hexrelief::cuda
