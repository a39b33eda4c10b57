// The second direction to the left. There are few rows, so that what takes time is the way from one step to
// the next: one warp walks each segment to the right while another one walks the segment behind it to the
// left.
#pragma once

#include <cuda_awbarrier_primitives.h>

#include "cuda/matching/sgm/key_search.cuh"
#include "cuda/matching/sgm/segments.cuh"

namespace hexrelief::cuda {

inline constexpr int kWarp = 32;

// The sums of a segment, handed from one warp to the other.
template <typename Shape>
struct RowSums {
    alignas(16) std::uint32_t words[2][kSegment<Shape::kPer>][Shape::kPairs / 4][kWarp][4];

    __device__ void put(int buffer, int k, const typename Shape::Pairs& pairs) {
#pragma unroll
        for (int i = 0; i < Shape::kPairs / 4; ++i)
            store_words<4>(pairs + 4 * i, words[buffer][k][i][threadIdx.x % kWarp]);
    }
    __device__ void get(int buffer, int k, typename Shape::Pairs& pairs) const {
#pragma unroll
        for (int i = 0; i < Shape::kPairs / 4; ++i)
            load_words<4>(words[buffer][k][i][threadIdx.x % kWarp], pairs + 4 * i);
    }
};

// Two warps meet, each at a place of its own: not __syncthreads(), which is for one place.
class MeetingPoint {
  public:
    __device__ explicit MeetingPoint(__mbarrier_t* barrier) : barrier_(barrier) {
        if (threadIdx.x == 0) __mbarrier_init(barrier, blockDim.x);
        __syncthreads();
    }
    __device__ void meet() const {
        const __mbarrier_token_t arrived = __mbarrier_arrive(barrier_);
        while (!__mbarrier_test_wait(barrier_, arrived)) {
        }
    }

  private:
    __mbarrier_t* barrier_;
};

template <typename Shape>
__device__ void walk_right_again(const LanePath<Shape>& path, int end, const MeetingPoint& point,
                                 RowSums<Shape>& row) {
    constexpr int kSteps = kSegment<Shape::kPer>;
    const auto walk_segment = [&](auto whole, const Segment<Shape>& segment, int number, int steps) {
        typename Shape::Pairs vertical[kSteps] = {}, sums[kSteps];
#pragma unroll
        for (int k = 0; k < kSteps; ++k)
            if (whole.value || k < steps) path.reader.read_sums(number * kSteps + k, vertical[k]);
        segment.template walk_forth<whole.value>(path, steps, sums);
#pragma unroll
        for (int k = 0; k < kSteps; ++k) {
            if (!whole.value && k >= steps) continue;
#pragma unroll
            for (int pair = 0; pair < Shape::kPairs; ++pair) sums[k][pair] += vertical[k][pair];
            row.put(number % 2, k, sums[k]);
        }
        point.meet();
    };
    walk_segments_back<Shape>(
        end,
        [&](Segment<Shape>& segment, int number, int steps) { segment.read_with_start(path, number, steps); },
        walk_segment);
}

template <typename Shape>
__device__ void walk_left_behind(const LanePath<Shape>& path, int end, const MeetingPoint& point,
                                 const RowSums<Shape>& row, const KeyRows& rows) {
    constexpr int kSteps = kSegment<Shape::kPer>;
    PathCosts<Shape> back;
    back.begin(path.range, path.p1);
    KeySearch<Shape> search(rows, path.number, path.range, path.exists);
    const auto walk_segment = [&](auto whole, const Segment<Shape>& segment, int number, int steps) {
        point.meet();
#pragma unroll
        for (int k = kSteps - 1; k >= 0; --k) {
            if (!whole.value && k >= steps) continue;
            typename Shape::Pairs sums;
            row.get(number % 2, k, sums);
            segment.step_back(path, k, back);
            add_costs<Shape>(back.pairs, path.p1, sums);
            if (path.exists) path.reader.write_sums(number * kSteps + k, sums);
            search.find(number * kSteps + k, sums);
        }
    };
    walk_segments_back<Shape>(
        end, [&](Segment<Shape>& segment, int number, int steps) { segment.read(path, number, steps); },
        walk_segment);
    search.store_rest();
}

template <typename Shape>
__global__ void __launch_bounds__(2 * kWarp)
    walk_left_kernel(const Paths paths, int steps, const KeyRows rows) {
    __shared__ RowSums<Shape> row;
    __shared__ __mbarrier_t barrier;
    const MeetingPoint point(&barrier);
    const LanePath<Shape> path(paths, blockIdx.x * kWarp + threadIdx.x % kWarp);
    if (threadIdx.x < kWarp)
        walk_right_again(path, steps, point, row);
    else
        walk_left_behind(path, steps, point, row, rows);
}

}  // namespace hexrelief::cuda
