// Marks the per-element steps that the CPU loop and the CUDA kernels both call.
// Only + - * / sqrt, integers and tables are allowed in them, so that both round alike.
#pragma once

#ifdef __CUDACC__
#define HEXRELIEF_HD __host__ __device__ __forceinline__
#else
#define HEXRELIEF_HD inline
#endif

// Before a loop of constant length.
#ifdef __CUDA_ARCH__
#define HEXRELIEF_UNROLL _Pragma("unroll")
#elif defined(__CUDACC__)
#define HEXRELIEF_UNROLL
#else
#define HEXRELIEF_UNROLL _Pragma("GCC unroll 8")
#endif
// Before a loop that must not be unrolled: a persistent kernel has to fit the instruction cache.
#ifdef __CUDA_ARCH__
#define HEXRELIEF_ROLLED _Pragma("unroll 1")
#else
#define HEXRELIEF_ROLLED
#endif

namespace hexrelief::step {

template <typename T>
HEXRELIEF_HD T min_of(T a, T b) {
    return b < a ? b : a;
}

template <typename T>
HEXRELIEF_HD T max_of(T a, T b) {
    return a < b ? b : a;
}

template <typename T>
HEXRELIEF_HD T clamp_to(T v, T lo, T hi) {
    return v < lo ? lo : hi < v ? hi : v;
}

}  // namespace hexrelief::step
