// Communicators: the threads that balance a level together, as one block, one cluster of blocks or the whole
// grid. A communicator says which rows and items belong to a thread, and how the threads wait for each other,
// add up, and pass on what they changed. Unlike cooperative_groups, it also knows the level's data layout.
// Included only by balance.cu.
#pragma once

#include <cooperative_groups.h>

#include <cstdint>

#include "cuda/balance/edge_integrals.cuh"
#include "mesher/balance/convergence_step.h"

namespace hexrelief::cuda {

__device__ __forceinline__ std::int64_t sum_of_warp(std::int64_t value) {
    for (int step = 16; step > 0; step /= 2) value += __shfl_xor_sync(0xFFFFFFFFu, value, step);
    return value;
}

// The data that each block keeps in shared memory for its communicator.
struct SharedScratch {
    static constexpr int kPartials = 16 * 16;  // blocks of a cluster x warps of a block
    step::BalanceSums partial[2][kPartials];   // this iteration's and the preceding one's
    int flags[3];
    int next_batch;  // next batch of edges or vertices to measure
};

// Returns the counter's value and then adds 1; a whole warp calls and gets the same number.
__device__ __forceinline__ int next_of(int& counter) {
    const int mine = threadIdx.x % 32 == 0 ? atomicAdd(&counter, 1) : 0;
    return __shfl_sync(0xFFFFFFFFu, mine, 0);
}

__device__ __forceinline__ step::BalanceSums sum_of_warp(const step::BalanceSums& s) {
    return {sum_of_warp(s.weight), sum_of_warp(s.deviation), sum_of_warp(s.thin)};
}

// Returns the sum of `count` partial sums, computed by each warp separately.
__device__ __forceinline__ step::BalanceSums sum_of_partials(const step::BalanceSums* partial, int count) {
    step::BalanceSums sum{0, 0, 0};
    for (int k = threadIdx.x % 32; k < count; k += 32) {
        sum.weight += partial[k].weight;
        sum.deviation += partial[k].deviation;
        sum.thin += partial[k].thin;
    }
    return sum_of_warp(sum);
}

// One block, which has all rows.
struct BlockCommunicator {
    static constexpr bool kWindowed = true;
    int first_row, last_row, thread, threads;
    SharedScratch* scratch;
    EdgeHelpers helpers;

    __device__ void wait() { __syncthreads(); }
    // True if `mine` is nonzero for any thread; waits for all.
    __device__ bool any(int mine) { return __syncthreads_or(mine); }
    // Adds the thread's share to the sums of iteration t.
    __device__ void add(step::BalanceSums mine, int t) {
        mine = sum_of_warp(mine);
        if (threadIdx.x % 32 == 0) scratch->partial[t & 1][threadIdx.x / 32] = mine;
    }
    // Returns the sums over all threads; valid after a wait, until the sums of iteration t + 2 are added.
    __device__ step::BalanceSums sums_of(int t) const {
        return sum_of_partials(scratch->partial[t & 1], blockDim.x / 32);
    }
    __device__ void dismiss_helpers() const { helpers.dismiss(); }
    // All threads see all rows, so nothing has to be passed on.
    template <typename T>
    __device__ void share(T*, int, int) {}
    template <typename T>
    __device__ void share_far(T*, int, int) {}
};

#if __CUDA_ARCH__ >= 900

// A block of a cluster. It has its own rows and, as a halo, copies of the adjacent rows, which the
// neighbouring blocks keep up to date through distributed shared memory.
struct ClusterCommunicator {
    static constexpr bool kWindowed = true;
    int first_row, last_row, thread, threads;
    SharedScratch* scratch;
    EdgeHelpers helpers;
    int block, blocks, rows_per_block;
    int checks;
    // bytes from an address in this block to the same one in a neighbouring block
    std::ptrdiff_t to_previous, to_next;

    template <typename T>
    __device__ static T* of_block(T* own, int other) {
        return cooperative_groups::this_cluster().map_shared_rank(own, other);
    }
    __device__ void wait() {
        asm volatile("barrier.cluster.arrive.release.aligned;\n\tbarrier.cluster.wait.acquire.aligned;" ::
                         : "memory");
    }
    __device__ bool any(int mine) {
        const int slot = checks++ % 3;
        if (__any_sync(0xFFFFFFFFu, mine) && static_cast<int>(threadIdx.x % 32) < blocks)
            *of_block(&scratch->flags[slot], threadIdx.x % 32) = 1;
        if (threadIdx.x == 0) scratch->flags[(slot + 1) % 3] = 0;
        wait();
        return *static_cast<volatile int*>(&scratch->flags[slot]) != 0;
    }
    __device__ void add(step::BalanceSums mine, int t) {
        mine = sum_of_warp(mine);
        const int lane = threadIdx.x % 32, warps = blockDim.x / 32;
        if (lane < blocks) *of_block(&scratch->partial[t & 1][block * warps + threadIdx.x / 32], lane) = mine;
    }
    __device__ step::BalanceSums sums_of(int t) const {
        return sum_of_partials(scratch->partial[t & 1], blocks * static_cast<int>(blockDim.x / 32));
    }
    template <typename T>
    __device__ static void put(T* own, std::ptrdiff_t bytes) {
        *reinterpret_cast<T*>(reinterpret_cast<char*>(own) + bytes) = *own;
    }
    __device__ void dismiss_helpers() const {
        if (block == 0) helpers.dismiss();
    }
    // Passes the value at `own`, in an array of row_length entries per row, on to the preceding and following
    // block if their halo of kRows rows holds a copy of it.
    template <int kRows, typename T>
    __device__ void share_rows(T* own, int row, int row_length) {
        const std::ptrdiff_t shift = static_cast<std::ptrdiff_t>(rows_per_block) * row_length * sizeof(T);
        if (row < first_row + kRows && block > 0) put(own, to_previous + shift);
        if (row >= first_row + rows_per_block - kRows && block + 1 < blocks) put(own, to_next - shift);
    }
    template <typename T>
    __device__ void share(T* own, int row, int row_length) {
        share_rows<1>(own, row, row_length);
    }
    // Does the same for values that are read two rows away.
    template <typename T>
    __device__ void share_far(T* own, int row, int row_length) {
        share_rows<2>(own, row, row_length);
    }
};

#endif

// All blocks of a cooperative grid, with the level in global memory.
struct GridCommunicator {
    static constexpr bool kWindowed = false;
    int first_row, last_row, thread, threads;
    SharedScratch* scratch;
    step::BalanceSums* sums;
    int* flags;
    int checks;

    __device__ void wait() { cooperative_groups::this_grid().sync(); }
    __device__ bool any(int mine) {
        const int slot = checks++ % 3;
        if (__any_sync(0xFFFFFFFFu, mine) && threadIdx.x % 32 == 0) __stcg(&flags[slot], 1);
        if (thread == 0) __stcg(&flags[(slot + 1) % 3], 0);
        wait();
        return __ldcg(&flags[slot]) != 0;
    }
    __device__ static void add_to(std::int64_t& sum, std::int64_t mine) {
        atomicAdd(reinterpret_cast<unsigned long long*>(&sum), static_cast<unsigned long long>(mine));
    }
    __device__ void add(step::BalanceSums mine, int t) {
        mine = sum_of_warp(mine);
        if (threadIdx.x % 32 == 0) scratch->partial[0][threadIdx.x / 32] = mine;
        __syncthreads();
        if (threadIdx.x < 32) {
            mine = sum_of_partials(scratch->partial[0], blockDim.x / 32);
            step::BalanceSums& all = sums[t % 3];
            if (threadIdx.x == 0) add_to(all.weight, mine.weight);
            if (threadIdx.x == 1) add_to(all.deviation, mine.deviation);
            if (threadIdx.x == 2) add_to(all.thin, mine.thin);
        }
        if (thread == 0) {
            step::BalanceSums& next = sums[(t + 1) % 3];
            __stcg(&next.weight, std::int64_t{0});
            __stcg(&next.deviation, std::int64_t{0});
            __stcg(&next.thin, std::int64_t{0});
        }
    }
    __device__ step::BalanceSums sums_of(int t) const {
        const step::BalanceSums& all = sums[t % 3];
        return {__ldcg(&all.weight), __ldcg(&all.deviation), __ldcg(&all.thin)};
    }
    template <typename T>
    __device__ void share(T*, int, int) {}
    template <typename T>
    __device__ void share_far(T*, int, int) {}
};

}  // namespace hexrelief::cuda
