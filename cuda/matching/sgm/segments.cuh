// Segments of paths: the data that a lane reads of one, and the steps through it in either direction.
#pragma once

#include "cuda/matching/sgm/path_costs.cuh"
#include "cuda/matching/sgm/paths.h"

namespace hexrelief::cuda {

// A thread's part of half a path.
template <int kRun>
struct LanePath {
    static constexpr int kSearched = 2 * kRun;
    bool exists;  // false: it repeats another path and writes nothing
    const HalfPaths& paths;
    int number;
    std::ptrdiff_t first;  // pixel at step 0

    // thread: index over all paths.
    __device__ LanePath(const HalfPaths& all, unsigned thread) : paths(all) {
        const int group = static_cast<int>(thread / kGroup);
        exists = group < all.count;
        number = exists ? group : all.count - 1;
        first = all.first + static_cast<std::ptrdiff_t>(number) * all.next_path;
    }
    __device__ std::ptrdiff_t pixel(int step) const {
        return first + static_cast<std::ptrdiff_t>(step) * paths.next_step;
    }
    __device__ PathPixel at(int step) const { return __ldg(paths.pixels + pixel(step)); }
    __device__ int segments() const { return (paths.steps + kSegment - 1) / kSegment; }
    // Costs of the inward direction before a segment.
    __device__ std::uint16_t* kept_before(int segment) const {
        return paths.kept + (static_cast<std::ptrdiff_t>(number) * segments() + segment) * kSearched;
    }
    // Costs of the inward direction at step 0.
    __device__ std::uint16_t* inwards() const {
        return paths.inwards + static_cast<std::ptrdiff_t>(number) * kSearched;
    }
    // Costs of the inward direction at step 0 of the other half.
    __device__ const std::uint16_t* outwards() const {
        return paths.outwards + static_cast<std::ptrdiff_t>(number) * kSearched;
    }
};

// The data of a segment. They are read some steps before it is walked, as they do not depend on the path.
template <int kRun>
struct Segment {
    LaneCosts<kRun> costs[kSegment];
    PathPixel pixels[kSegment + 1];  // and the one behind, or the one before if outwards is against the axis
    LanePairs<kRun> start;           // stored costs of the inward direction before the segment
    PathPixel start_pixel;

    // steps: number of pixels that exist; unless it is constant, the compiler moves many registers.
    __device__ void read(const LanePath<kRun>& path, int number, int steps = kSegment) {
        const int first = number * kSegment;
#pragma unroll
        for (int k = 0; k <= kSegment; ++k) {
            if (k <= steps) pixels[k] = path.at(first + k - path.paths.against_axis);
            if (k == kSegment || k >= steps) continue;
            const std::uint8_t* const of_pixel = path.paths.costs + path.pixel(first + k) * path.kSearched;
            if constexpr (kRun == matching::kLongRun) {
                const uint4 words = reinterpret_cast<const uint4*>(of_pixel)[lane_of_group()];
                costs[k][0] = words.x;
                costs[k][1] = words.y;
                costs[k][2] = words.z;
                costs[k][3] = words.w;
            } else {
                const uint2 words = reinterpret_cast<const uint2*>(of_pixel)[lane_of_group()];
                costs[k][0] = words.x;
                costs[k][1] = words.y;
            }
        }
    }
    __device__ void read_start(const LanePath<kRun>& path, int number) {
        load_pairs(path.kept_before(number), start);
        start_pixel = path.at(min((number + 1) * kSegment, path.paths.steps - 1));
    }
    // Returns the word of pixel k for a step to it, inwards or outwards: with its own window, and with the
    // penalty of the pixel that is farther along the axis.
    __device__ PathPixel inwards_to(const LanePath<kRun>& path, int k) const {
        return taken_from(pixels[k], pixels[k + 1], path.paths.against_axis ? ~0u : kPenalty);
    }
    __device__ PathPixel outwards_to(const LanePath<kRun>& path, int k) const {
        return taken_from(pixels[k], pixels[k + 1], path.paths.against_axis ? ~kPenalty : 0u);
    }

  private:
    // Takes these bits from `second`.
    __device__ static PathPixel taken_from(PathPixel first, PathPixel second, std::uint32_t bits) {
        return (first & ~bits) | (second & bits);
    }
};

}  // namespace hexrelief::cuda
