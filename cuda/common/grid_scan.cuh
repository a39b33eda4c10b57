// Prefix sums by all threads of a cooperative grid.
#pragma once

#include <cub/block/block_scan.cuh>
#include <type_traits>

#include "cuda/common/grid.cuh"

namespace hexrelief::cuda {

// Calls visit(i, sum of value(j) over all j < i) for each i < count, followed by a barrier; returns the total
// to all threads. Values are unsigned or unsigned long long. The same thread reads each value twice, first as
// value(i), then as again(i), which must not depend on what visit() writes.
template <typename Value, typename Again, typename Visit>
__device__ auto exclusive_scan(const CooperativeGrid& grid, unsigned count, const Value& value,
                               const Again& again, const Visit& visit) {
    using Sum =
        std::conditional_t<sizeof(value(0u)) == sizeof(unsigned long long), unsigned long long, unsigned>;
    using BlockScan = cub::BlockScan<Sum, kGridThreads, cub::BLOCK_SCAN_WARP_SCANS>;
    __shared__ typename BlockScan::TempStorage storage;
    const auto scan_block = [&](Sum mine, Sum& total) {
        Sum before;
        BlockScan(storage).ExclusiveSum(mine, before, total);
        __syncthreads();
        return before;
    };
    unsigned long long* const sums = grid.board().sums;
    const unsigned share = (count + gridDim.x - 1) / gridDim.x, first = min(count, blockIdx.x * share),
                   end = min(count, first + share);
    Sum mine = 0, own, before = 0, all = 0;
    for (unsigned i = first + threadIdx.x; i < end; i += kGridThreads) mine += value(i);
    scan_block(mine, own);
    if (threadIdx.x == 0) sums[blockIdx.x] = own;
    grid.wait();
    for (unsigned b = threadIdx.x; b < gridDim.x; b += kGridThreads) {
        const Sum sum = static_cast<Sum>(sums[b]);
        all += sum;
        if (b < blockIdx.x) before += sum;
    }
    scan_block(before, before);
    scan_block(all, all);
    for (unsigned start = first; start < end; start += kGridThreads) {
        const unsigned i = start + threadIdx.x;
        Sum total;
        const Sum sum = before + scan_block(i < end ? static_cast<Sum>(again(i)) : Sum{0}, total);
        if (i < end) visit(i, sum);
        before += total;
    }
    grid.wait();
    return all;
}
// Does the same for values that can be read as value(i) both times.
template <typename Value, typename Visit>
__device__ auto exclusive_scan(const CooperativeGrid& grid, unsigned count, const Value& value,
                               const Visit& visit) {
    return exclusive_scan(grid, count, value, value, visit);
}

}  // namespace hexrelief::cuda
