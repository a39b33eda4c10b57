// The paths of semi-global matching: from above, below, the left and the right. Both directions of an axis
// are walked at once, each from its end to the middle, and their costs are stored before each segment of some
// pixels. Then both go on through the other half: in each segment a direction repeats the other one from its
// stored costs and adds both. So the sums are written once, and no direction waits for another.
#pragma once

#include "cuda/matching/sgm/volume.h"

namespace hexrelief::cuda {

inline constexpr int kSegment = 8;  // pixels; as many as a lane can keep in registers

// The paths of an axis on one side of their middles, in a band. Steps are counted outwards from the middle;
// pixels and arrays are counted row by row from the band's first row.
struct HalfPaths {
    int count, steps;
    std::ptrdiff_t first;      // index of the pixel of path 0 at step 0
    int next_path, next_step;  // in pixels
    const std::uint8_t* costs;
    std::uint16_t* sums;
    const PathPixel* pixels;  // with penalties of steps along the axis
    std::uint16_t* kept;      // costs of the inward direction before each segment, path by path
    // costs of the inward direction at step 0, where the other half's outward direction begins
    std::uint16_t* inwards;
    const std::uint16_t* outwards;  // those of the other half
    int other_steps;
    int against_axis;  // 1 if outwards is against the axis, else 0
};

struct KeptCosts {
    struct Axis {
        std::uint16_t *before_segments[2], *at_middles[2];  // one for each half of a path
    };
    Axis rows, columns;
};
// Takes the memory for a volume of `rows` rows, with `searched` disparities at each pixel.
KeptCosts take_kept_costs(Arena& arena, int width, int rows, int searched);

// Sets the sums of all rows of the band, whose costs must be known.
void walk_paths(cudaStream_t stream, const DeviceVolume& volume, int p1, const KeptCosts& kept);

}  // namespace hexrelief::cuda
