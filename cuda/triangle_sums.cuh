// How warps go through the pixels of the sheet's triangles.
#pragma once

#include "cuda/sheet_crew.cuh"
#include "cuda/sheet_state.cuh"

namespace hexrelief::cuda {

// A warp's number; consecutive ones lie in different blocks, so that little work is spread over all of them.
template <typename Crew>
__device__ unsigned scattered_warp(const Crew& crew) {
    return threadIdx.x / 32 * (crew.threads() / blockDim.x) + crew.thread() / blockDim.x;
}

// Ordered sums of nine numbers a pixel, by one warp.
class PixelSums {
  public:
    static constexpr int kSums = 9;
    static constexpr unsigned kPixels = 256;  // of all warps at a time: a block's shared memory is 18 KB

    // Shared by the block.
    __device__ explicit PixelSums(double (*scratch)[kSums])
        : at_once_(min(32u, kPixels / (blockDim.x / 32) / 8 * 8)),
          scratch_(scratch + threadIdx.x / 32 * at_once_) {}

    // Adds the lanes' numbers, lane by lane; lane k keeps sum k.
    __device__ void add(const double (&mine)[kSums], unsigned used_lanes) {
        const unsigned lane = threadIdx.x % 32;
        for (unsigned first = 0; first < used_lanes; first += at_once_) {
            __syncwarp();
            if (lane >= first && lane < first + at_once_) {
#pragma unroll
                for (int k = 0; k < kSums; ++k) scratch_[lane - first][k] = mine[k];
            }
            __syncwarp();
            const unsigned k = lane < kSums ? lane : 0;
            for (unsigned i = 0; i < at_once_; i += 8) {
#pragma unroll
                for (unsigned j = 0; j < 8; ++j) sum_ += scratch_[i + j][k];
            }
        }
    }
    __device__ double take() {
        const double sum = sum_;
        sum_ = 0;
        return sum;
    }

  private:
    unsigned at_once_;  // a multiple of 8
    double (*scratch_)[kSums];
    double sum_ = 0;
};

// A warp visits pixels of runs in their order: visit(x, y, is one, lanes that are used), all lanes at once.
template <typename Visit>
__device__ void each_32_pixels(const PixelRun* runs, unsigned count, const Visit& visit) {
    const unsigned lane = threadIdx.x % 32;
    for (unsigned start = 0; start < count; start += 32) {
        const PixelRun run = start + lane < count ? runs[start + lane] : PixelRun{};
        unsigned end = static_cast<unsigned>(run.end - run.first);  // of the run, in pixels of these runs
        for (unsigned step = 1; step < 32; step *= 2) {
            const unsigned before = __shfl_up_sync(~0u, end, step);
            if (lane >= step) end += before;
        }
        const unsigned all = __shfl_sync(~0u, end, 31);
        const int shift = run.end - static_cast<int>(end);  // from a pixel's number to its column
        for (unsigned first = 0; first < all; first += 32) {
            const unsigned pixel = first + lane;
            unsigned r = 0;  // its run: so many end at or before it
#pragma unroll
            for (unsigned step = 16; step > 0; step /= 2)
                if (__shfl_sync(~0u, end, r + step - 1) <= pixel) r += step;
            const int x = static_cast<int>(pixel) + __shfl_sync(~0u, shift, r & 31),
                      y = __shfl_sync(~0u, run.y, r & 31);
            visit(x, y, pixel < all, min(32u, all - first));
        }
    }
}

// visit(t, first run, runs) for the triangles that `chosen` says, each by a whole warp.
template <typename Crew, typename Chosen, typename Visit>
__device__ void each_chosen_triangle(const Crew& crew, const SheetState& s, unsigned count,
                                     const Chosen& chosen, const Visit& visit) {
    const unsigned lane = crew.lane(), warps = crew.threads() / 32;
    // A warp's next 32 triangles are looked at side by side.
    for (unsigned base = scattered_warp(crew); base < count; base += 32 * warps) {
        const unsigned mine = base + lane * warps;
        const bool is_chosen = mine < count && chosen(mine);
        unsigned first = 0, runs = 0;
        if (is_chosen) {
            const unsigned* const start = &s.sides.run_starts[s.sheet.origins[mine]];
            first = start[0];
            runs = start[1] - first;
        }
        for (unsigned left = __ballot_sync(~0u, is_chosen); left != 0; left &= left - 1) {
            const unsigned from = static_cast<unsigned>(__ffs(static_cast<int>(left))) - 1;
            visit(base + from * warps, s.sides.runs + __shfl_sync(~0u, first, from),
                  __shfl_sync(~0u, runs, from));
        }
    }
}

}  // namespace hexrelief::cuda
