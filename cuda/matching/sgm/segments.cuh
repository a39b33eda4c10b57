// Segments of paths: what a lane reads of one, and walking it in either direction.
#pragma once

#include "cuda/matching/sgm/path_costs.cuh"
#include "cuda/matching/sgm/paths.h"

namespace hexrelief::cuda {

// A thread's part of half a path.
template <int kRun>
struct LanePath {
    static constexpr int kSearched = 2 * kRun;
    bool exists;  // or another one stands for it
    const HalfPaths& paths;
    int number;
    std::ptrdiff_t first;  // pixel at step 0

    // thread: counted over all paths.
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
    // Costs of the way inwards, before a segment and at step 0, and of the other half's.
    __device__ std::uint16_t* kept_before(int segment) const {
        return paths.kept + (static_cast<std::ptrdiff_t>(number) * segments() + segment) * kSearched;
    }
    __device__ std::uint16_t* inwards() const {
        return paths.inwards + static_cast<std::ptrdiff_t>(number) * kSearched;
    }
    __device__ const std::uint16_t* outwards() const {
        return paths.outwards + static_cast<std::ptrdiff_t>(number) * kSearched;
    }
};

// Read some steps before it is walked, as nothing here depends on the path.
template <int kRun>
struct Segment {
    LaneCosts<kRun> costs[kSegment];
    PathPixel pixels[kSegment + 1];  // and the one behind, or, where outwards is against the axis, before
    LanePairs<kRun> start;           // costs of the way inwards before it, where they were kept
    PathPixel start_pixel;

    // steps: of the pixels that are there; where it is no constant, the compiler moves many registers.
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
    // Pixel k as a step to it reads it, from the one behind it or before it: the window is its own, the
    // penalty that of the one of both which is farther along the axis.
    __device__ PathPixel inwards_to(const LanePath<kRun>& path, int k) const {
        return taken_from(pixels[k], pixels[k + 1], path.paths.against_axis ? ~0u : kPenalty);
    }
    __device__ PathPixel outwards_to(const LanePath<kRun>& path, int k) const {
        return taken_from(pixels[k], pixels[k + 1], path.paths.against_axis ? ~kPenalty : 0u);
    }

  private:
    // These bits of the second one.
    __device__ static PathPixel taken_from(PathPixel first, PathPixel second, std::uint32_t bits) {
        return (first & ~bits) | (second & bits);
    }
};

}  // namespace hexrelief::cuda
