// Words that follow each other, in accesses as wide as there are.
#pragma once

#include <cuda_runtime.h>

#include <cstdint>

namespace hexrelief::cuda {

// kWords is 2 or a multiple of 4; `from` and `to` are aligned to 8 or 16 bytes.
template <int kWords>
__device__ void load_words(const std::uint32_t* from, std::uint32_t* words) {
    if constexpr (kWords == 2) {
        const uint2 value = *reinterpret_cast<const uint2*>(from);
        words[0] = value.x;
        words[1] = value.y;
    } else {
        static_assert(kWords % 4 == 0);
#pragma unroll
        for (int k = 0; k < kWords; k += 4) {
            const uint4 value = *reinterpret_cast<const uint4*>(from + k);
            words[k] = value.x;
            words[k + 1] = value.y;
            words[k + 2] = value.z;
            words[k + 3] = value.w;
        }
    }
}
template <int kWords>
__device__ void store_words(const std::uint32_t* words, std::uint32_t* to) {
    static_assert(kWords % 4 == 0);
#pragma unroll
    for (int k = 0; k < kWords; k += 4)
        *reinterpret_cast<uint4*>(to + k) = make_uint4(words[k], words[k + 1], words[k + 2], words[k + 3]);
}

}  // namespace hexrelief::cuda
