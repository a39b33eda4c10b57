// The threads of a persistent kernel, and what they do together.
#pragma once

#include <type_traits>

namespace hexrelief::cuda {

inline constexpr unsigned kMostGridBlocks = 1024;
inline constexpr unsigned kMostGridWarps = 16;  // of a block: what each keeps in shared memory must fit

// What the blocks tell each other.
struct GridBoard {
    unsigned long long sums[kMostGridBlocks];
    // All 0 before the launch, from here on.
    alignas(128) unsigned flags[3];
    alignas(128) unsigned barrier;  // blocks that have come; its highest bit turns when all have
};

// All blocks of a cooperative launch. Every member function is called by all threads alike. Blocks are whole
// warps, kMostGridWarps at most.
class CooperativeGrid {
  public:
    __device__ CooperativeGrid(unsigned block, unsigned blocks, GridBoard* board)
        : block_(block), blocks_(blocks), board_(board) {}

    // Lanes of a warp follow each other; warps go round the blocks, so that little work keeps all of them
    // busy.
    __device__ unsigned thread() const {
        return (threadIdx.x / 32 * blocks_ + block_) * 32 + threadIdx.x % 32;
    }
    __device__ unsigned threads() const { return blocks_ * blockDim.x; }
    __device__ unsigned warp() const { return thread() / 32; }
    __device__ unsigned lane() const { return threadIdx.x % 32; }

    // A barrier: what any thread wrote before, all see after.
    __device__ void wait() const {
        unsigned* const barrier = &board_->barrier;
        constexpr unsigned kTurn = 1u << 31;
        unsigned before = 0;
        if (threadIdx.x == 0)  // stays until the block itself has come
            asm volatile("ld.relaxed.gpu.global.u32 %0, [%1];" : "=r"(before) : "l"(barrier) : "memory");
        __syncthreads();
        if (threadIdx.x == 0) {
            const unsigned one = block_ == 0 ? kTurn - (blocks_ - 1) : 1;
            asm volatile("red.release.gpu.global.add.u32 [%0], %1;" ::"l"(barrier), "r"(one) : "memory");
            unsigned now;
            do {
                asm volatile("ld.acquire.gpu.global.u32 %0, [%1];" : "=r"(now) : "l"(barrier) : "memory");
            } while (!((now ^ before) & kTurn));
        }
        __syncthreads();
    }

    // visit(i) for each i < count, then a barrier.
    template <typename Visit>
    __device__ void each(unsigned count, const Visit& visit) const {
        for (unsigned i = thread(); i < count; i += threads()) visit(i);
        wait();
    }
    // The same by whole warps: visit(i, lane), all lanes of a warp with the same i.
    template <typename Visit>
    __device__ void each_by_warp(unsigned count, const Visit& visit) const {
        for (unsigned i = thread() / 32; i < count; i += threads() / 32) visit(i, lane());
        wait();
    }
    // visit(i, sum of value(j) over all j < i); returns the sum of all, to all. Values are unsigned, or
    // unsigned long long. value is called twice, by the same thread, and must not depend on what visit
    // writes.
    template <typename Value, typename Visit>
    __device__ auto scan(unsigned count, const Value& value, const Visit& visit) const {
        return scan(count, value, value, visit);
    }
    // The same where the second call, again(i), knows the value from the first.
    template <typename Value, typename Again, typename Visit>
    __device__ auto scan(unsigned count, const Value& value, const Again& again, const Visit& visit) const {
        using Sum =
            std::conditional_t<sizeof(value(0u)) == sizeof(unsigned long long), unsigned long long, unsigned>;
        const unsigned share = (count + blocks_ - 1) / blocks_, first = min(count, block_ * share),
                       end = min(count, first + share);
        Sum mine = 0;
        for (unsigned i = first + threadIdx.x; i < end; i += blockDim.x) mine += value(i);
        const Sum own = block_sum(mine).total;
        if (threadIdx.x == 0) board_->sums[block_] = own;
        wait();
        Sum before = 0, all = 0;
        for (unsigned b = threadIdx.x; b < blocks_; b += blockDim.x) {
            const Sum sum = static_cast<Sum>(board_->sums[b]);
            all += sum;
            if (b < block_) before += sum;
        }
        before = block_sum(before).total;
        all = block_sum(all).total;
        for (unsigned start = first; start < end; start += blockDim.x) {
            const unsigned i = start + threadIdx.x;
            const auto sum = block_sum(i < end ? static_cast<Sum>(again(i)) : Sum{0});
            if (i < end) visit(i, before + sum.before);
            before += sum.total;
        }
        wait();
        return all;
    }
    // Whether any thread says so; a barrier.
    __device__ bool any(bool mine) {
        volatile unsigned* const flags = board_->flags;
        if (mine) flags[turn_] = 1;
        const unsigned now = turn_;
        turn_ = (turn_ + 1) % 3;
        if (thread() == 0) flags[turn_] = 0;  // all have read it: they came past a barrier since
        wait();
        return flags[now] != 0;
    }

  private:
    template <typename Sum>
    struct Sums {
        Sum before, total;
    };
    // Over the threads of the block: the sum of those before, and of all.
    template <typename Sum>
    __device__ static __noinline__ Sums<Sum> block_sum(Sum mine) {
        __shared__ Sum warps[32];
        const unsigned lane = threadIdx.x % 32, warp = threadIdx.x / 32;
        Sum sum = mine;
        for (unsigned step = 1; step < 32; step *= 2) {
            const Sum other = __shfl_up_sync(~0u, sum, step);
            if (lane >= step) sum += other;
        }
        if (lane == 31) warps[warp] = sum;
        __syncthreads();
        if (warp == 0) {
            Sum own = lane < blockDim.x / 32 ? warps[lane] : 0;
            for (unsigned step = 1; step < 32; step *= 2) {
                const Sum other = __shfl_up_sync(~0u, own, step);
                if (lane >= step) own += other;
            }
            warps[lane] = own;
        }
        __syncthreads();
        const Sums<Sum> result{(warp > 0 ? warps[warp - 1] : 0) + sum - mine, warps[31]};
        __syncthreads();
        return result;
    }

    unsigned block_, blocks_;
    GridBoard* board_;
    unsigned turn_ = 0;
};

}  // namespace hexrelief::cuda
