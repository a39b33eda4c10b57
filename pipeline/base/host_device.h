// Marks the per-element steps that both the CPU loops and the CUDA kernels call. Such steps may use only + -
// * / sqrt, integers and tables, so that both backends round alike.
#pragma once

#ifdef __CUDACC__
#define HEXRELIEF_HD __host__ __device__ __forceinline__
#else
#define HEXRELIEF_HD inline
#endif

// Stands before a loop of constant length that is to be unrolled.
#ifdef __CUDA_ARCH__
#define HEXRELIEF_UNROLL _Pragma("unroll")
#elif defined(__CUDACC__)
#define HEXRELIEF_UNROLL
#else
#define HEXRELIEF_UNROLL _Pragma("GCC unroll 8")
#endif
// Stands before a loop that must not be unrolled, because a persistent kernel has to
// fit the instruction cache.
#ifdef __CUDA_ARCH__
#define HEXRELIEF_ROLLED _Pragma("unroll 1")
#else
#define HEXRELIEF_ROLLED
#endif

namespace hexrelief::step {

// The smaller of two values, `a` if they are equal. (The standard's functions are not
// callable on the device.)
template <typename T>
HEXRELIEF_HD T min_of(T a, T b) {
    return b < a ? b : a;
}

// The larger of two values, `a` if they are equal.
template <typename T>
HEXRELIEF_HD T max_of(T a, T b) {
    return a < b ? b : a;
}

// `v` clamped to [lo, hi].
template <typename T>
HEXRELIEF_HD T clamp_to(T v, T lo, T hi) {
    return v < lo ? lo : hi < v ? hi : v;
}

}  // namespace hexrelief::step
