// The threads of a cooperative grid, and the operations that they do together.
#pragma once

#include <cooperative_groups.h>

#include <cstdint>
#include <cub/block/block_scan.cuh>
#include <type_traits>

#include "cuda/common/launch.h"
#include "cuda/common/warp_reduce.cuh"

namespace hexrelief::cuda {

inline constexpr unsigned kAllLanes = 0xffffffffu;  // all lanes of a warp

// All blocks of launch_cooperative(), a team like ThreadTeam. All threads must call each member function
// together.
class CooperativeGrid {
  public:
    static constexpr int kBlock = 1;  // pixels that a thread works on at a time: neighbours read together

    __device__ explicit CooperativeGrid(GridBoard* board) : board_(board), vote_(board->last_vote) {}

    // Index of the thread in the grid. The lanes of a warp are successive; warps are distributed round-robin
    // over the blocks, so that a small amount of work keeps all blocks busy.
    __device__ unsigned thread() const {
        return (threadIdx.x / 32 * gridDim.x + blockIdx.x) * 32 + threadIdx.x % 32;
    }
    __device__ unsigned threads() const { return gridDim.x * kGridThreads; }
    __device__ unsigned warp() const { return thread() / 32; }
    __device__ unsigned warps() const { return gridDim.x * kGridWarps; }
    __device__ unsigned lane() const { return threadIdx.x % 32; }
    __device__ bool is_first() const { return thread() == 0; }

    // A barrier: all threads see after it what any thread wrote before it.
    __device__ void wait() const { cooperative_groups::this_grid().sync(); }

    // Calls visit(i) for each i < count, followed by a barrier.
    template <typename Visit>
    __device__ void each(unsigned count, const Visit& visit) const {
        for (unsigned i = thread(); i < count; i += threads()) visit(i);
        wait();
    }
    // Calls visit(x, y) for each pixel of a map, followed by a barrier.
    template <typename Visit>
    __device__ void each_block(int width, int height, const Visit& visit) const {
        each(static_cast<unsigned>(width) * height, [&](unsigned i) {
            const unsigned y = i / width;
            visit(static_cast<int>(i - y * width), static_cast<int>(y));
        });
    }
    // Replaces the numbers of each line by their prefix sums, followed by a barrier. Lines begin `apart`
    // numbers apart, and hold `count` numbers that are `stride` apart.
    __device__ void sum_lines(std::uint32_t* numbers, std::size_t lines, std::size_t apart, std::size_t count,
                              std::size_t stride) const {
        constexpr unsigned kAtOnce = 4;
        each_by_warp(lines, [&](unsigned line, unsigned lane) {
            std::uint32_t* const first = numbers + line * apart;
            std::uint32_t before = 0;
            for (std::size_t start = lane; start - lane < count; start += 32 * kAtOnce) {
                std::uint32_t own[kAtOnce];
                HEXRELIEF_UNROLL
                for (unsigned k = 0; k < kAtOnce; ++k)
                    own[k] = start + 32 * k < count ? first[(start + 32 * k) * stride] : 0;
                HEXRELIEF_UNROLL
                for (unsigned k = 0; k < kAtOnce; ++k) {
                    own[k] = before + sum_up_to_lane(own[k]);
                    before = __shfl_sync(kAllLanes, own[k], 31);
                    if (start + 32 * k < count) first[(start + 32 * k) * stride] = own[k];
                }
            }
        });
    }
    // Calls visit(i, lane) for each i < count with all lanes of a warp, followed by a barrier.
    template <typename Visit>
    __device__ void each_by_warp(unsigned count, const Visit& visit) const {
        for (unsigned i = warp(); i < count; i += warps()) visit(i, lane());
        wait();
    }
    // True for all threads if `mine` is true for any; includes a barrier.
    __device__ bool any(bool mine) {
        // Two slots are enough: before the next vote but one, all threads have passed
        // the next vote's barrier.
        volatile unsigned* const yes = &board_->votes[++vote_ % 2];
        if (mine) *yes = vote_;
        wait();
        if (thread() == 0) board_->last_vote = vote_;
        return *yes == vote_;
    }
    __device__ GridBoard& board() const { return *board_; }

  private:
    GridBoard* board_;
    unsigned vote_;
};

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
