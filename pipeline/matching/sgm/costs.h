// The matching costs of a picture's rows.
#pragma once

#include <vector>

#include "pipeline/matching/common/color_planes.h"
#include "pipeline/matching/sgm/volume.h"

namespace hexrelief::matching {

// Computes the costs of one row at a time. Holds scratch memory, so each thread needs its own object.
class CostRows {
  public:
    CostRows(const ColorPlanes& left, const ColorPlanes& right, const DisparityRange& range,
             WindowView windows);
    // Computes row y of a MatchingVolume. A pixel whose match lies outside of the right picture is compared
    // with the pixel at its edge.
    void compute(int y, std::uint8_t* costs);

  private:
    const ColorPlanes &left_, &right_;
    DisparityRange range_;
    WindowView windows_;
    std::size_t mirrored_width_;
    std::vector<std::uint8_t> left_census_, right_census_, mirrored_census_, mirrored_colors_;
};

}  // namespace hexrelief::matching
