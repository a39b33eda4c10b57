// The paths of semi-global matching: from above, below, the left and the right. Of the two directions of an
// axis the first is walked alone, and its costs are kept before each segment of some pixels only. The second
// one walks each segment anew from there in the first direction, and adds both: so the sums are written once.
#pragma once

#include "cuda/matching/sgm/pictures.h"
#include "cuda/matching/sgm/volume.h"

namespace hexrelief::cuda {

inline constexpr int kSegment = 8;  // pixels; as many as a lane can keep in registers

// The paths of an axis in a band, in the order of its first direction. Pixels are counted row by row from the
// band's first on, as are the arrays.
struct Paths {
    int count, steps;
    int next_path, next_step;  // pixels from one to the next
    const std::uint8_t* costs;
    std::uint16_t* sums;
    const std::uint16_t* penalties;                    // of a large step from the pixel before
    const std::uint32_t* windows;                      // SearchWindow, packed
    std::uint16_t* kept;                               // the costs before each segment
    std::ptrdiff_t kept_next_path, kept_next_segment;  // pixels' entries from one to the next
    std::uint32_t p1;                                  // as a pair
};

struct KeptCosts {
    std::uint16_t *of_rows, *of_columns;
};
// For a volume with so many rows.
KeptCosts take_kept_costs(Arena& arena, int width, int rows);

// Sets the sums of all rows of the band, whose costs are known.
void walk_paths(cudaStream_t stream, const PairArrays& pair, const DeviceVolume& volume, int p1,
                const KeptCosts& kept);

}  // namespace hexrelief::cuda
