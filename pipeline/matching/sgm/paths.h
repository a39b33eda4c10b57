// The paths of semi-global matching: from the left, the right, above and below.
#pragma once

#include "mesher/common/thread_pool.h"
#include "pipeline/matching/common/color_planes.h"
#include "pipeline/matching/sgm/path_step.h"
#include "pipeline/matching/sgm/volume.h"

namespace hexrelief {

// What is matched: two pictures of one size and as many channels.
struct MatchingInput {
    const ColorPlanes &left, &right;
    DisparityRange range;
    step::PathPenalties penalties;
};

// The costs of vertical paths at rows of pixels: where they come from outside of a volume.
class PathRows {
  public:
    PathRows(int rows, int width, int count);  // not initialised
    // width * count, disparities innermost.
    std::uint16_t* row(int index) { return costs_.data() + static_cast<std::size_t>(index) * row_entries_; }
    void begin(int index);  // paths that begin below or above this row

  private:
    std::size_t row_entries_;
    LargeArray<std::uint16_t> costs_;
};

// Sets the volume's costs, and its sums to the sum of the four paths' costs. above: paths from above at the
// row before the volume's first. below: paths from below at the row after its last, replaced by those at its
// first.
void aggregate(const MatchingInput& input, const std::uint16_t* above, std::uint16_t* below,
               MatchingVolume& volume, ThreadPool& pool);

// Follows the paths from above through the volume, to those at its last row. Sets its costs, no sums.
void descend(const MatchingInput& input, const std::uint16_t* above, std::uint16_t* last,
             MatchingVolume& volume, ThreadPool& pool);

}  // namespace hexrelief
