// The threads of a cooperative grid, and the operations that they do together.
#pragma once

#include <cooperative_groups.h>

#include "cuda/common/cooperative_launch.h"

namespace hexrelief::cuda {

inline constexpr unsigned kAllLanes = 0xffffffffu;  // all lanes of a warp

// All blocks of launch_cooperative(). All threads must call each member function together.
class CooperativeGrid {
  public:
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

    // A barrier: all threads see after it what any thread wrote before it.
    __device__ void wait() const { cooperative_groups::this_grid().sync(); }

    // Calls visit(i) for each i < count, followed by a barrier.
    template <typename Visit>
    __device__ void each(unsigned count, const Visit& visit) const {
        for (unsigned i = thread(); i < count; i += threads()) visit(i);
        wait();
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

}  // namespace hexrelief::cuda
