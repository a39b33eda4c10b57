// Smoothing along the planes of a disparity map.
#pragma once

#include <cstdint>

#include "mesher/common/host_device.h"
#include "pipeline/matching/refine/slope_step.h"

namespace hexrelief::step {

// Windows of 5x5 pixels at strides of 1, 2 and 4 px, as in the a-trous wavelet transform
// (Dammertz et al. 2010).
inline constexpr int kSmoothRadius = 2, kSmoothLevels = 3;
inline constexpr int kSmoothReach = 44;  // 1/16 px: pixels this far off the plane have no weight
inline constexpr int kSmoothColor = 20;  // a larger colour step ends a surface

// The disparity and the slopes of a pixel.
template <typename Int>
struct PlanePoint {
    Int disparity, slope_x, slope_y;
};
// Returns the distance of a pixel (dx, dy) px away from the plane through this one; the plane has the mean
// of both pixels' slopes.
template <typename Int>
HEXRELIEF_HD Int off_plane(const PlanePoint<Int>& own, const PlanePoint<Int>& other, Int dx, Int dy) {
    const auto along_x = static_cast<Int>(static_cast<Int>(own.slope_x + other.slope_x) * dx);
    const auto along_y = static_cast<Int>(static_cast<Int>(own.slope_y + other.slope_y) * dy);
    const auto offset = static_cast<Int>(static_cast<Int>(along_x + along_y + 16) >> 5);
    return static_cast<Int>(other.disparity - offset - own.disparity);
}

// Returns the weight of a pixel, at most 9 * 44. kernel: 1..9, by its position in the window. alike: it is
// known and its colour step is at most kSmoothColor.
template <typename Int>
HEXRELIEF_HD Int smoothing_weight(Int off, Int kernel, bool alike) {
    const auto below = static_cast<Int>(kSmoothReach + off), above = static_cast<Int>(kSmoothReach - off);
    const Int nearness = below < above ? below : above;
    const Int counted = nearness > 0 ? nearness : Int{0};
    return static_cast<Int>(kernel * counted) & mask_of<Int>(alike);
}
template <typename Int>
HEXRELIEF_HD constexpr Int smoothing_kernel(int i, int j) {
    return static_cast<Int>((3 - (i < 0 ? -i : i)) * (3 - (j < 0 ? -j : j)));
}

template <typename Int>
HEXRELIEF_HD std::int16_t smoothed(std::int16_t disparity, std::int32_t weighted_offs, Int weights) {
    const int mean =
        rounded_quotient(static_cast<float>(weighted_offs), static_cast<float>(weights > 1 ? weights : 1));
    const auto moved = static_cast<std::int16_t>(disparity + mean);
    return disparity < 0 ? disparity : moved > 0 ? moved : std::int16_t{0};
}

}  // namespace hexrelief::step
