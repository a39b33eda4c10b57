// The best disparities of both views' pixels, along a walk to the left.
#pragma once

#include "cuda/matching/sgm/path_costs.cuh"
#include "cuda/matching/sgm/winners.h"

namespace hexrelief::cuda {

struct KeyRows {
    WinnerKeys keys;
    int min_px, width;
};

// Of a row. What matches a pixel of the right view moves down by a disparity with each step to the left, so
// the best key of each of the right view's pixels that the left one may match moves through the lanes.
template <typename Shape>
class KeySearch {
  public:
    // stores: or the row is another's.
    __device__ KeySearch(const KeyRows& rows, int row, const LaneRange<Shape>& range, bool stores)
        : range_(range),
          left_keys_(rows.keys.left + static_cast<std::size_t>(row) * rows.width),
          right_keys_(rows.keys.right + static_cast<std::size_t>(row) * rows.width),
          min_px_(rows.min_px),
          width_(rows.width),
          stores_(stores) {
#pragma unroll
        for (int k = 0; k < Shape::kPer; ++k) right_[k] = step::kNoWinner;
#pragma unroll
        for (int k = 0; k < Shape::kPairs; ++k)
            disparities_[k] = static_cast<std::uint32_t>(range.first() + k) * 0x10001u +
                              (static_cast<std::uint32_t>(Shape::kPairs) << 16);
    }

    // Pixel x, the next one to the left, with its sums of path costs.
    __device__ void find(int x, const typename Shape::Pairs& sums) {
        const std::uint32_t next_lanes = __shfl_down_sync(~0u, right_[0], 1, Shape::kGroup);
        const std::uint32_t arriving = range_.last ? step::kNoWinner : next_lanes;
        std::uint32_t best = step::kNoWinner;
#pragma unroll
        for (int k = 0; k < Shape::kPer; ++k) {
            const int pair = k % Shape::kPairs;
            // step::winner_key() in one instruction
            const std::uint32_t key = __byte_perm(range_.or_none(sums[pair], pair, 0xffffffffu),
                                                  disparities_[pair], k < Shape::kPairs ? 0x1054 : 0x3276);
            best = min(best, key);
            right_[k] = min(key, k + 1 < Shape::kPer ? right_[k + 1] : arriving);
        }
        best = least_key(range_.any ? best : step::kNoWinner);
        if (range_.lane == 0 && stores_) {
            const int column = x - min_px_;
            left_keys_[x] = best;
            if (column >= 0 && column < width_) right_keys_[column] = right_[0];
        }
    }

    // After the row's first pixel: the keys of the right view's pixels that match it.
    __device__ void store_rest() const {
        if (!stores_ || !range_.any) return;
#pragma unroll
        for (int k = 0; k < Shape::kPer; ++k) {
            const int column = -min_px_ - (range_.first() + k);
            if (column >= 0 && column < width_) right_keys_[column] = right_[k];
        }
    }

  private:
    __device__ static std::uint32_t least_key(std::uint32_t key) {
        if constexpr (Shape::kGroup == 32) {
            return least_of_lanes(key);
        } else {
#pragma unroll
            for (int step = Shape::kGroup / 2; step > 0; step /= 2)
                key = min(key, __shfl_xor_sync(~0u, key, step, Shape::kGroup));
            return key;
        }
    }

    const LaneRange<Shape>& range_;
    std::uint32_t *left_keys_, *right_keys_;
    int min_px_, width_;
    bool stores_;
    std::uint32_t disparities_[Shape::kPairs];
    std::uint32_t right_[Shape::kPer];
};

}  // namespace hexrelief::cuda
