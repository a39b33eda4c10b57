// Where the paths of an axis lie in memory, and how a lane reads and writes its part of one.
#pragma once

#include "cuda/matching/sgm/path_costs.cuh"
#include "cuda/matching/sgm/word_access.cuh"

namespace hexrelief::cuda {

// In the order of the axis's first direction, down or to the right. Step 0 is the first pixel with sums.
// Numbers of pixels count those of the picture, row by row.
struct Paths {
    int count;
    std::ptrdiff_t first;                  // pixel of path 0 at step 0
    int next_path, next_step;              // pixels from one to the next
    std::ptrdiff_t costs_from, sums_from;  // the pixel that the arrays begin with
    const std::uint8_t* costs;
    std::uint16_t* sums;
    const std::uint16_t* penalties;  // of a large step from the pixel before
    int disparities, pitch;
    std::uint32_t p1;  // as a pair
    // The costs before each segment.
    std::uint16_t* before_segments;
    int kept_next_path, kept_next_segment;  // pixels from one to the next
};

template <typename Shape>
class PathReader {
  public:
    __device__ PathReader(const Paths& paths, int path, const LaneRange<Shape>& range)
        : next_step_(paths.next_step),
          next_entry_(static_cast<std::ptrdiff_t>(paths.next_step) * paths.pitch),
          next_kept_(static_cast<std::ptrdiff_t>(paths.kept_next_segment) * paths.pitch),
          any_(range.any) {
        const std::ptrdiff_t pixel = paths.first + static_cast<std::ptrdiff_t>(path) * paths.next_path;
        costs_ = paths.costs + (pixel - paths.costs_from) * paths.pitch + range.first();
        sums_ = paths.sums + (pixel - paths.sums_from) * paths.pitch + range.first();
        kept_ = paths.before_segments +
                static_cast<std::ptrdiff_t>(path) * paths.kept_next_path * paths.pitch + range.first();
        penalties_ = paths.penalties + pixel;
    }
    // The matching costs of kSteps pixels from `step` on, and the penalties of large steps between pixels,
    // from the one before `step` to the one behind the last. Of these pixels `steps` are there. Values are
    // kept as they are read, so that nothing waits for them here.
    template <int kSteps>
    __device__ void read(int step, int steps, typename Shape::Costs (&costs)[kSteps],
                         std::uint32_t (&penalties)[kSteps + 1]) const {
        const std::uint8_t* from = costs_ + step * next_entry_;
        const std::uint16_t* penalty = penalties_ + static_cast<std::ptrdiff_t>(step) * next_step_;
#pragma unroll
        for (int k = 0; k <= kSteps; ++k) {
            if (k > steps) break;
            if (k < kSteps && k < steps && any_) load_words<Shape::kPer / 4>(from, costs[k]);
            penalties[k] = __ldg(penalty);
            from += next_entry_;
            penalty += next_step_;
        }
    }
    __device__ void read_sums(int step, typename Shape::Pairs& sums) const {
        if (any_) load_words<Shape::kPairs>(sums_ + step * next_entry_, sums);
    }
    __device__ void write_sums(int step, const typename Shape::Pairs& sums) const {
        if (any_) store_words<Shape::kPairs>(sums, sums_ + step * next_entry_);
    }
    __device__ void read_kept(int segment, typename Shape::Pairs& costs) const {
        if (any_) load_words<Shape::kPairs>(kept_ + segment * next_kept_, costs);
    }
    __device__ void keep(int segment, const typename Shape::Pairs& costs) const {
        if (any_) store_words<Shape::kPairs>(costs, kept_ + segment * next_kept_);
    }

  private:
    int next_step_;
    std::ptrdiff_t next_entry_, next_kept_;
    bool any_;
    const std::uint8_t* costs_;
    std::uint16_t *sums_, *kept_;
    const std::uint16_t* penalties_;
};

}  // namespace hexrelief::cuda
