// The paths of semi-global matching: from above, below, the left and the right. Of the two directions of an
// axis the first is walked alone, and its costs are kept before each segment of some pixels only. The second
// one walks each segment anew from there in the first direction, and adds both: so the sums are written once.
#pragma once

#include "cuda/matching/sgm/pictures.h"
#include "cuda/matching/sgm/volume.h"
#include "cuda/matching/sgm/winners.h"

namespace hexrelief::cuda {

inline constexpr int kMostDisparities = 2048;

// Of a volume with this many disparities (see DeviceVolume).
int disparities_a_lane(int count);
// Pixels of a segment.
int segment_steps(int count);

struct PathInput {
    const PairArrays& pair;
    DeviceVolume volume;
    WinnerKeys keys;
    int p1, min_px;
};

// Walks down from the band's first row to its last kept one. before_segments <- the costs before each segment
// of the kept rows, counted from the first: a row of the volume's pixels a segment.
void walk_down(cudaStream_t stream, const PathInput& input, const Band& band, std::uint16_t* before_segments);

// Walks up through `rows`, some of the band's kept ones that begin with a segment, whose sums the volume
// keeps: from the band's last row, or, where rows of the band's kept ones were walked before, from the costs
// at the last of these. Sets the sums. before_segments: from the first of `rows` on. costs_here: the costs at
// the row walked last, read and written; width * pitch entries.
void walk_up(cudaStream_t stream, const PathInput& input, const Band& band, const Rows& rows,
             std::uint16_t* before_segments, std::uint16_t* costs_here);

// Walks to the right in `rows`. before_segments <- the costs before each segment of columns of each row.
void walk_right(cudaStream_t stream, const PathInput& input, const Rows& rows,
                std::uint16_t* before_segments);

// Walks to the left in all rows that the volume keeps, of the first of which before_segments begin. Adds both
// directions to the sums, and sets the keys, the right view's only where they match a pixel.
void walk_left(cudaStream_t stream, const PathInput& input, std::uint16_t* before_segments);

}  // namespace hexrelief::cuda
