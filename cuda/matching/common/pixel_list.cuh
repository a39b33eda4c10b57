// Lists of the few pixels that need much work: one kernel lists them for others, whose
// threads share them evenly.
#pragma once

#include <algorithm>

#include "cuda/common/launch.h"
#include "cuda/common/warp_reduce.cuh"
#include "cuda/matching/common/pixel_list.h"
#include "cuda/matching/common/pixels.cuh"

namespace hexrelief::cuda {

// Lists the pixels for which `listed` is true. All threads of a block of pixel_blocks() call it together,
// each for its own pixel. A block adds its pixels together, because one atomic addition per warp would make
// warps wait for each other.
__device__ inline void add_to_list(const PixelList& list, bool listed, int2 at) {
    __shared__ unsigned count, first;
    const bool is_first = threadIdx.x == 0 && threadIdx.y == 0;
    if (is_first) count = 0;
    __syncthreads();
    const unsigned lanes = __ballot_sync(~0u, listed);
    unsigned before = 0;
    if (threadIdx.x == 0) before = atomicAdd(&count, static_cast<unsigned>(__popc(lanes)));
    before = __shfl_sync(~0u, before, 0) + count_before_lane(lanes);
    __syncthreads();
    if (is_first && count > 0) first = atomicAdd(list.count, count);
    __syncthreads();
    if (listed)
        list.pixels[first + before] =
            static_cast<std::uint32_t>(at.y) << 16 | static_cast<std::uint32_t>(at.x);
}

// Returns the i-th listed pixel.
__device__ inline int2 listed_pixel(const PixelList& list, unsigned i) {
    const std::uint32_t pixel = list.pixels[i];
    return {static_cast<int>(pixel & 0xffffu), static_cast<int>(pixel >> 16)};
}

// Blocks for kernels that give each listed pixel a thread or a warp, even if all pixels of
// the picture are listed.
constexpr int kListBlock = 128;
inline Blocks list_blocks(int width, int height) {
    constexpr int kMostBlocks = 132 * 48;  // several rounds of blocks on any device
    return {std::min(kMostBlocks, blocks_for(static_cast<std::size_t>(width) * height, kListBlock)),
            kListBlock};
}
// Calls work(x, y) for the thread's share of the listed pixels.
template <typename Work>
__device__ void for_each_listed(const PixelList& list, const Work& work) {
    const unsigned count = *list.count;
    for (unsigned i = blockIdx.x * kListBlock + threadIdx.x; i < count; i += gridDim.x * kListBlock) {
        const int2 at = listed_pixel(list, i);
        work(at.x, at.y);
    }
}

}  // namespace hexrelief::cuda
