// Words that follow each other, in accesses as wide as there are.
#pragma once

#include <cuda_runtime.h>

#include <cstdint>

namespace hexrelief::cuda {

// kWords is 2 or a multiple of 4; `from` and `to` are aligned to 8 or 16 bytes.
template <int kWords>
__device__ void load_words(const void* from, std::uint32_t* words) {
    if constexpr (kWords == 2) {
        const uint2 value = *static_cast<const uint2*>(from);
        words[0] = value.x;
        words[1] = value.y;
    } else {
        static_assert(kWords % 4 == 0);
#pragma unroll
        for (int k = 0; k < kWords; k += 4) {
            const uint4 value = static_cast<const uint4*>(from)[k / 4];
            words[k] = value.x;
            words[k + 1] = value.y;
            words[k + 2] = value.z;
            words[k + 3] = value.w;
        }
    }
}
template <int kWords>
__device__ void store_words(const std::uint32_t* words, void* to) {
    static_assert(kWords % 4 == 0);
#pragma unroll
    for (int k = 0; k < kWords; k += 4)
        static_cast<uint4*>(to)[k / 4] = make_uint4(words[k], words[k + 1], words[k + 2], words[k + 3]);
}

}  // namespace hexrelief::cuda
