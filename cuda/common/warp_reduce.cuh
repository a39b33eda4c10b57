// Minimum, maximum and prefix sums over the lanes of a warp; all lanes must call.
#pragma once

namespace hexrelief::cuda {

// Reduces values of any type, and on devices before compute capability 8.0, which have no instruction for it.
template <typename Value, typename Better>
__device__ Value reduce_warp(Value value, const Better& better) {
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

// Do the same for non-negative floats, which have the order of their bits.
__device__ inline float least_of_lanes(float value) {
    return __uint_as_float(least_of_lanes(__float_as_uint(value)));
}
__device__ inline float most_of_lanes(float value) {
    return __uint_as_float(most_of_lanes(__float_as_uint(value)));
}

__device__ inline unsigned sum_of_lanes(unsigned value) {
#if __CUDA_ARCH__ >= 800
    return __reduce_add_sync(~0u, value);
#else
    return reduce_warp(value, [](unsigned a, unsigned b) { return a + b; });
#endif
}
// Returns the bits that are set in any lane.
__device__ inline unsigned any_of_lanes(unsigned bits) {
#if __CUDA_ARCH__ >= 800
    return __reduce_or_sync(~0u, bits);
#else
    return reduce_warp(bits, [](unsigned a, unsigned b) { return a | b; });
#endif
}

// Returns how many of these lanes, a bit each, come before this one.
__device__ inline unsigned count_before_lane(unsigned lanes) {
    return __popc(lanes & ((1u << threadIdx.x % 32) - 1));
}

// Returns the sum of integers over the lanes up to and including this one. `lanes`, a power of 2: each group
// of this many lanes has its own sums.
template <typename Sum>
__device__ Sum sum_up_to_lane(Sum value, unsigned lanes = 32) {
    for (unsigned step = 1; step < lanes; step *= 2) {
        const Sum before = __shfl_up_sync(~0u, value, step);
        if (threadIdx.x % lanes >= step) value += before;
    }
    return value;
}

}  // namespace hexrelief::cuda
