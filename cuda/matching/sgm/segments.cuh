// Segments of paths: what a lane reads of one, and walking it in either direction.
#pragma once

#include "cuda/matching/sgm/path_costs.cuh"
#include "cuda/matching/sgm/paths.h"
#include "cuda/matching/sgm/word_access.cuh"

namespace hexrelief::cuda {

// A thread's part of a path.
struct LanePath {
    bool exists;  // or another one stands for it
    const Paths& paths;
    std::ptrdiff_t first;  // pixel at step 0
    std::uint16_t* kept;

    // thread: counted over all paths.
    __device__ LanePath(const Paths& all, unsigned thread) : paths(all) {
        const int group = static_cast<int>(thread / kGroup);
        exists = group < all.count;
        const int number = exists ? group : all.count - 1;
        first = static_cast<std::ptrdiff_t>(number) * all.next_path;
        kept = all.kept + number * all.kept_next_path * kSearched + lane_of_group() * kLaneEntries;
    }
    __device__ std::ptrdiff_t pixel(int step) const {
        return first + static_cast<std::ptrdiff_t>(step) * paths.next_step;
    }
    __device__ std::ptrdiff_t entry(int step) const {
        return pixel(step) * kSearched + lane_of_group() * kLaneEntries;
    }
    __device__ std::uint16_t* kept_before(int segment) const {
        return kept + segment * paths.kept_next_segment * kSearched;
    }
    __device__ PackedWindow window(int step) const { return __ldg(paths.windows + pixel(step)); }
};

// Read some steps before it is walked, as nothing here depends on the path.
struct Segment {
    LaneCosts costs[kSegment];
    std::uint32_t penalties[kSegment + 1];  // of large steps, from the one to the first pixel on
    PackedWindow windows[kSegment];
    LanePairs start;  // the path's costs before, where they were kept
    PackedWindow start_window;

    // `steps` of the pixels are there.
    __device__ void read(const LanePath& path, int number, int steps) {
        const int first = number * kSegment;
#pragma unroll
        for (int k = 0; k <= kSegment; ++k) {
            if (k > steps) break;
            penalties[k] = __ldg(path.paths.penalties + path.pixel(first + k));
            if (k == kSegment || k == steps) break;
            load_words<kLaneEntries / 4>(path.paths.costs + path.entry(first + k), costs[k]);
            windows[k] = path.window(first + k);
        }
    }
    __device__ void read_with_start(const LanePath& path, int number, int steps) {
        load_words<kLanePairs>(path.kept_before(number), start);
        start_window = path.window(max(number * kSegment - 1, 0));
        read(path, number, steps);
    }
    __device__ void step_forth(const LanePath& path, int k, PathCosts& forth) const {
        forth.advance(costs[k], path.paths.p1, penalties[k], windows[k]);
    }
    // To step k from the one behind it.
    __device__ void step_back(const LanePath& path, int k, PathCosts& back) const {
        back.advance(costs[k], path.paths.p1, penalties[k + 1], windows[k]);
    }
};

}  // namespace hexrelief::cuda
