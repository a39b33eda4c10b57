// The paths of semi-global matching: from above, below, the left and the right. Both directions of an axis
// are walked at once, each from its end to the middle, and their costs kept before each segment of some
// pixels. Then both go on: each walks the segments of the other half, and in each of them the other direction
// anew from what that kept, and adds both. So the sums are written once, and no direction waits for another.
#pragma once

#include "cuda/matching/sgm/volume.h"

namespace hexrelief::cuda {

inline constexpr int kSegment = 8;  // pixels; as many as a lane can keep in registers

// What an axis's paths have on one side of their middles, in a band. Steps are counted outwards from the
// middle, pixels row by row from the band's first on, as are the arrays.
struct HalfPaths {
    int count, steps;
    std::ptrdiff_t first;      // pixel of path 0 at step 0
    int next_path, next_step;  // pixels from one to the next
    const std::uint8_t* costs;
    std::uint16_t* sums;
    const PathPixel* pixels;        // with penalties of steps along the axis
    std::uint16_t* kept;            // costs of the way inwards before each segment, path by path
    std::uint16_t* inwards;         // those at step 0, where the other half's way outwards begins
    const std::uint16_t* outwards;  // of the other half
    int other_steps;
    int against_axis;  // 1 where outwards is against the axis, else 0
};

struct KeptCosts {
    struct Axis {
        std::uint16_t *before_segments[2], *at_middles[2];  // of each half
    };
    Axis rows, columns;
};
// For a volume with so many rows, and disparities searched at each pixel.
KeptCosts take_kept_costs(Arena& arena, int width, int rows, int searched);

// Sets the sums of all rows of the band, whose costs are known.
void walk_paths(cudaStream_t stream, const DeviceVolume& volume, int p1, const KeptCosts& kept);

}  // namespace hexrelief::cuda
