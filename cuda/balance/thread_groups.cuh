// The groups that balance a level: how their threads wait, add up, and tell each other what they changed.
// Included by balance.cu only.
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

// What a group's blocks keep in shared memory.
struct GroupScratch {
    static constexpr int kPartials = 16 * 16;  // blocks of a cluster x warps of a block
    step::BalanceSums partial[2][kPartials];   // of this iteration and the one before
    int flags[3];
    int next_piece;  // of what is measured
};

// The next number, by a whole warp.
__device__ __forceinline__ int next_of(int& counter) {
    const int mine = threadIdx.x % 32 == 0 ? atomicAdd(&counter, 1) : 0;
    return __shfl_sync(0xFFFFFFFFu, mine, 0);
}

__device__ __forceinline__ step::BalanceSums sum_of_warp(const step::BalanceSums& s) {
    return {sum_of_warp(s.weight), sum_of_warp(s.deviation), sum_of_warp(s.thin)};
}

// Sum of `count` partial sums, by each warp for itself.
__device__ __forceinline__ step::BalanceSums sum_of_partials(const step::BalanceSums* partial, int count) {
    step::BalanceSums sum{0, 0, 0};
    for (int k = threadIdx.x % 32; k < count; k += 32) {
        sum.weight += partial[k].weight;
        sum.deviation += partial[k].deviation;
        sum.thin += partial[k].thin;
    }
    return sum_of_warp(sum);
}

// One block with all rows.
struct BlockGroup {
    static constexpr bool kWindowed = true;
    int first_row, last_row, thread, threads;
    GroupScratch* scratch;
    EdgeHelpers helpers;

    __device__ void wait() { __syncthreads(); }
    // Whether any thread says so; waits.
    __device__ bool any(int mine) { return __syncthreads_or(mine); }
    // Adds to the sums of iteration t.
    __device__ void add(step::BalanceSums mine, int t) {
        mine = sum_of_warp(mine);
        if (threadIdx.x % 32 == 0) scratch->partial[t & 1][threadIdx.x / 32] = mine;
    }
    // Those over all threads, after a wait and until the next but one is added to.
    __device__ step::BalanceSums sums_of(int t) const {
        return sum_of_partials(scratch->partial[t & 1], blockDim.x / 32);
    }
    __device__ void dismiss_helpers() const { helpers.dismiss(); }
    template <typename T>
    __device__ void share(T*, int, int) {}
    template <typename T>
    __device__ void share_far(T*, int, int) {}
};

#if __CUDA_ARCH__ >= 900

// A cluster's block: its rows, with those next to them as copies that the neighbouring blocks keep up to
// date.
struct ClusterGroup {
    static constexpr bool kWindowed = true;
    int first_row, last_row, thread, threads;
    GroupScratch* scratch;
    EdgeHelpers helpers;
    int block, blocks, rows_per_block;
    int checks;
    std::ptrdiff_t to_previous, to_next;  // from what is here to the same place of the neighbouring blocks

    template <typename T>
    __device__ static T* of_block(T* own, int other) {
        return cooperative_groups::this_cluster().map_shared_rank(own, other);
    }
    __device__ void wait() {
        asm volatile("barrier.cluster.arrive.release.aligned;\n\tbarrier.cluster.wait.acquire.aligned;" ::
                         : "memory");
    }
    __device__ bool any(int mine) {
        const int turn = checks++ % 3;
        if (__any_sync(0xFFFFFFFFu, mine) && static_cast<int>(threadIdx.x % 32) < blocks)
            *of_block(&scratch->flags[turn], threadIdx.x % 32) = 1;
        if (threadIdx.x == 0) scratch->flags[(turn + 1) % 3] = 0;
        wait();
        return *static_cast<volatile int*>(&scratch->flags[turn]) != 0;
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
    // Tells the blocks before and after what stands at `own`, in an array of row_length a row, where they
    // hold a copy of the row; kRows: how many of each block's they do.
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
    // The same for what is read two rows away.
    template <typename T>
    __device__ void share_far(T* own, int row, int row_length) {
        share_rows<2>(own, row, row_length);
    }
};

#endif

// All blocks of a cooperative launch, in global memory.
struct GridGroup {
    static constexpr bool kWindowed = false;
    int first_row, last_row, thread, threads;
    GroupScratch* scratch;
    step::BalanceSums* sums;
    int* flags;
    int checks;

    __device__ void wait() { cooperative_groups::this_grid().sync(); }
    __device__ bool any(int mine) {
        const int turn = checks++ % 3;
        if (__any_sync(0xFFFFFFFFu, mine) && threadIdx.x % 32 == 0) __stcg(&flags[turn], 1);
        if (thread == 0) __stcg(&flags[(turn + 1) % 3], 0);
        wait();
        return __ldcg(&flags[turn]) != 0;
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
