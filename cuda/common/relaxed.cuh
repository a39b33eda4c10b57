// Reads and writes memory that several blocks use without a barrier between them.
#pragma once

#include <cuda_runtime.h>

#include <cstring>
#include <type_traits>

namespace hexrelief::cuda {

// Reads a value in a single access of 4, 8 or 16 bytes that sees the last value written by another block. 16
// bytes need PTX: the compiler may move __ldcg() out of the loop that waits for a change.
template <typename T>
__device__ T load_relaxed(const T* from) {
    static_assert(sizeof(T) == 4 || sizeof(T) == 8 || sizeof(T) == 16);
    T value;
    if constexpr (sizeof(T) == 16) {
        uint4 word;
        asm volatile("ld.relaxed.gpu.global.v4.u32 {%0, %1, %2, %3}, [%4];"
                     : "=r"(word.x), "=r"(word.y), "=r"(word.z), "=r"(word.w)
                     : "l"(from)
                     : "memory");
        memcpy(&value, &word, sizeof value);
    } else {
        using Word = std::conditional_t<sizeof(T) == 8, unsigned long long, unsigned>;
        const Word word = *reinterpret_cast<const volatile Word*>(from);
        memcpy(&value, &word, sizeof value);
    }
    return value;
}
// Writes a value in a single access of 4, 8 or 16 bytes.
template <typename T>
__device__ void store_relaxed(T* to, const T& value) {
    static_assert(sizeof(T) == 4 || sizeof(T) == 8 || sizeof(T) == 16);
    if constexpr (sizeof(T) == 16) {
        uint4 word;
        memcpy(&word, &value, sizeof word);
        asm volatile("st.relaxed.gpu.global.v4.u32 [%0], {%1, %2, %3, %4};" ::"l"(to), "r"(word.x),
                     "r"(word.y), "r"(word.z), "r"(word.w)
                     : "memory");
    } else {
        using Word = std::conditional_t<sizeof(T) == 8, unsigned long long, unsigned>;
        Word word;
        memcpy(&word, &value, sizeof word);
        *reinterpret_cast<volatile Word*>(to) = word;
    }
}

}  // namespace hexrelief::cuda
