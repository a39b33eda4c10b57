// The paths of semi-global matching: from the left, the right, above and below.
#pragma once

#include <vector>

#include "pipeline/base/thread_pool.h"
#include "pipeline/matching/common/color_planes.h"
#include "pipeline/matching/sgm/path_step.h"
#include "pipeline/matching/sgm/volume.h"

namespace hexrelief::matching {

// The input of matching: two pictures of one size with equal numbers of channels.
struct MatchingInput {
    const ColorPlanes &left, &right;
    DisparityRange range;
    WindowView windows;
    step::PathPenalties penalties;
};

// The costs of vertical paths at the pixels of row y, increased by p1, in the layout of a
// row of a MatchingVolume.
struct PathRow {
    std::uint16_t* costs;
    int y;
};

// Rows at which vertical paths enter a volume from outside.
class PathRows {
  public:
    PathRows(int rows, std::size_t row_entries);  // costs are not initialised
    PathRow& row(int index) { return rows_[static_cast<std::size_t>(index)]; }
    // Sets the row to paths that begin at row y: their costs before it are 0, in the windows of its pixels.
    void begin(int index, int y, const step::PathPenalties& penalties);

  private:
    std::size_t row_entries_;
    LargeArray<std::uint16_t> costs_;
    std::vector<PathRow> rows_;
};

// Sets the volume's costs, and its sums to the sum of the four paths' costs. above: paths from above at the
// row before the volume's first row. below: paths from below at the row after its last row, replaced by those
// at its first row.
void aggregate(const MatchingInput& input, const PathRow& above, PathRow& below, MatchingVolume& volume,
               ThreadPool& pool);

// Follows the paths from above through the volume, and sets `last` to those at its last row. Sets the
// volume's costs but not its sums.
void descend(const MatchingInput& input, const PathRow& above, PathRow& last, MatchingVolume& volume,
             ThreadPool& pool);

}  // namespace hexrelief::matching
