// The threads of a cooperative launch, and what they do together.
#pragma once

#include <cooperative_groups.h>

#include "cuda/common/cooperative_launch.h"

namespace hexrelief::cuda {

inline constexpr unsigned kAllLanes = 0xffffffffu;  // of a warp

// All blocks of launch_cooperative(). Every member function is called by all threads alike.
class CooperativeGrid {
  public:
    __device__ explicit CooperativeGrid(GridBoard* board) : board_(board), vote_(board->last_vote) {}

    // Lanes of a warp follow each other; warps go round the blocks, so that little work keeps all of them
    // busy.
    __device__ unsigned thread() const {
        return (threadIdx.x / 32 * gridDim.x + blockIdx.x) * 32 + threadIdx.x % 32;
    }
    __device__ unsigned threads() const { return gridDim.x * kGridThreads; }
    __device__ unsigned warp() const { return thread() / 32; }
    __device__ unsigned warps() const { return gridDim.x * kGridWarps; }
    __device__ unsigned lane() const { return threadIdx.x % 32; }

    // A barrier: what any thread wrote before, all see after.
    __device__ void wait() const { cooperative_groups::this_grid().sync(); }

    // visit(i) for each i < count, then a barrier.
    template <typename Visit>
    __device__ void each(unsigned count, const Visit& visit) const {
        for (unsigned i = thread(); i < count; i += threads()) visit(i);
        wait();
    }
    // The same by whole warps: visit(i, lane), all lanes of a warp with the same i.
    template <typename Visit>
    __device__ void each_by_warp(unsigned count, const Visit& visit) const {
        for (unsigned i = warp(); i < count; i += warps()) visit(i, lane());
        wait();
    }
    // Whether any thread says so; a barrier.
    __device__ bool any(bool mine) {
        // Two places are enough: before the next vote but one, all have come past the next one's barrier.
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
