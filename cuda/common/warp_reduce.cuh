// Minimum and maximum over the lanes of a warp, all of which call.
#pragma once

namespace hexrelief::cuda {

// For devices before compute capability 8.0, which have no instruction for it.
template <typename Better>
__device__ unsigned reduce_warp(unsigned value, const Better& better) {
    for (int step = 16; step > 0; step /= 2) value = better(value, __shfl_xor_sync(~0u, value, step));
    return value;
}
__device__ inline unsigned least_of_lanes(unsigned value) {
#if __CUDA_ARCH__ >= 800
    return __reduce_min_sync(~0u, value);
#else
    return reduce_warp(value, [](unsigned a, unsigned b) { return min(a, b); });
#endif
}
__device__ inline unsigned most_of_lanes(unsigned value) {
#if __CUDA_ARCH__ >= 800
    return __reduce_max_sync(~0u, value);
#else
    return reduce_warp(value, [](unsigned a, unsigned b) { return max(a, b); });
#endif
}

// The same for floats that are not below 0: they are ordered as their bits.
__device__ inline float least_of_lanes(float value) {
    return __uint_as_float(least_of_lanes(__float_as_uint(value)));
}
__device__ inline float most_of_lanes(float value) {
    return __uint_as_float(most_of_lanes(__float_as_uint(value)));
}

}  // namespace hexrelief::cuda
