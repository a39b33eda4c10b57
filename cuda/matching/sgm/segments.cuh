// Segments of paths: walked in the first direction, and back.
#pragma once

#include <type_traits>

#include "cuda/matching/sgm/path_reader.cuh"

namespace hexrelief::cuda {

// As many pixels as a lane can keep in registers.
template <int kPer>
inline constexpr int kSegment = kPer <= 8    ? 8
                                : kPer <= 16 ? 4
                                : kPer <= 32 ? 2
                                             : 1;

// A thread's part of a path.
template <typename Shape>
struct LanePath {
    bool exists;  // or another one stands for it
    int number;
    LaneRange<Shape> range;
    PathReader<Shape> reader;
    std::uint32_t p1;

    // thread: counted over all paths.
    __device__ LanePath(const Paths& paths, unsigned thread)
        : exists(static_cast<int>(thread / Shape::kGroup) < paths.count),
          number(exists ? static_cast<int>(thread / Shape::kGroup) : paths.count - 1),
          range(paths.disparities),
          reader(paths, number, range),
          p1(paths.p1) {}
};
// What is read of a segment before it is walked: some steps ahead, as nothing here depends on the path.
template <typename Shape>
struct Segment {
    static constexpr int kSteps = kSegment<Shape::kPer>;
    typename Shape::Costs costs[kSteps];
    std::uint32_t penalties[kSteps + 1];
    typename Shape::Pairs start;  // the path's costs before, where they were kept

    __device__ void read(const LanePath<Shape>& path, int number, int steps = kSteps) {
        path.reader.read(number * kSteps, steps, costs, penalties);
    }
    __device__ void read_with_start(const LanePath<Shape>& path, int number, int steps = kSteps) {
        path.reader.read_kept(number, start);
        read(path, number, steps);
    }
    // From the start to the last of `steps` steps; kWhole: steps == kSteps. sums <- the costs at each.
    template <bool kWhole>
    __device__ void walk_forth(const LanePath<Shape>& path, int steps,
                               typename Shape::Pairs (&sums)[kSteps]) const {
        PathCosts<Shape> path_costs;
        path_costs.load(start, path.range);
#pragma unroll
        for (int k = 0; k < kSteps; ++k) {
            if (!kWhole && k >= steps) continue;
            path_costs.advance(costs[k], path.p1, penalties[k], path.range);
#pragma unroll
            for (int pair = 0; pair < Shape::kPairs; ++pair) sums[k][pair] = path_costs.pairs[pair];
        }
    }
    // To step k from the one behind it.
    __device__ void step_back(const LanePath<Shape>& path, int k, PathCosts<Shape>& back) const {
        back.advance(costs[k], path.p1, penalties[k + 1], path.range);
    }
};

// Walks over `steps` steps from step `first` on, forth or back, without sums.
template <bool kBack, typename Shape>
__device__ void walk(const LanePath<Shape>& path, int first, int steps, PathCosts<Shape>& costs) {
    constexpr int kSteps = kSegment<Shape::kPer>;
    for (int i = 0; i < steps; i += kSteps) {
        const int count = min(kSteps, steps - i), begin = kBack ? first + steps - i - count : first + i;
        Segment<Shape> pixels = {};
        path.reader.read(begin, count, pixels.costs, pixels.penalties);
#pragma unroll
        for (int k = 0; k < kSteps; ++k) {
            const int at = kBack ? kSteps - 1 - k : k;
            if (at < count)
                costs.advance(pixels.costs[at], path.p1, pixels.penalties[kBack ? at + 1 : at], path.range);
        }
    }
}

// Calls walk(kWhole, segment, number, steps) for all segments, the last one first, which may not be whole,
// and read(segment, number, steps) before the segment behind is walked.
template <typename Shape, typename Read, typename Walk>
__device__ void walk_segments_back(int end, const Read& read, const Walk& walk) {
    constexpr int kSteps = Segment<Shape>::kSteps;
    int number = (end - 1) / kSteps;
    const int in_last = end - number * kSteps;
    Segment<Shape> next = {};
    read(next, number, in_last);
    if (in_last < kSteps) {
        const Segment<Shape> here = next;
        if (number > 0) read(next, number - 1, kSteps);
        walk(std::false_type{}, here, number--, in_last);
    }
    for (; number >= 0; --number) {
        const Segment<Shape> here = next;
        if (number > 0) read(next, number - 1, kSteps);
        walk(std::true_type{}, here, number, kSteps);
    }
}

// sums <- the costs of both directions at a pixel, as they are; `more` are p1 larger, as the sums were.
template <typename Shape>
__device__ void add_costs(const typename Shape::Pairs& more, std::uint32_t p1, typename Shape::Pairs& sums) {
#pragma unroll
    for (int pair = 0; pair < Shape::kPairs; ++pair) sums[pair] = sums[pair] + more[pair] - 2 * p1;
}

}  // namespace hexrelief::cuda
