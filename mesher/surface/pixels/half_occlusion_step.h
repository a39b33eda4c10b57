// Low steps down to the right: next to them the other camera alone sees a few pixels of the farther surface,
// which a near surface that goes on a little too far, or a fit that rounds the step, hides.
#pragma once

#include <cstddef>
#include <cstdint>

#include "mesher/common/host_device.h"
#include "mesher/surface/pixels/crack_edges_step.h"
#include "mesher/surface/fit/fit_disparities_step.h"

namespace hexrelief::step {

inline constexpr float kLeastFall_px = 1;  // both cameras see what lies behind a lower one
inline constexpr int kFallReach_px = 2;    // of a fall to its right
inline constexpr float kMostFall_px = 6;
inline constexpr double kFallWeight = 20;  // of a pixel there in the disparities' fit, others 1

// Whether the last jump on the left of (x, y), not farther away than kFallReach_px, is a low fall.
HEXRELIEF_HD bool is_behind_low_fall(const PixelView& view, int x, int y) {
    const std::size_t i = view.index(x, y);
    for (int k = 1; k <= kFallReach_px && k <= x; ++k) {
        if (!(view.flags[i - k] & kJumpRight)) continue;
        const float near = view.disparity[i - k], far = view.disparity[i - k + 1];
        return (far > 0) & (near > far) & (near - far < kMostFall_px);
    }
    return false;
}

// Whether a jump to the right lies among or shortly before pixels first .. end - 1 of a row; without one,
// none of them is behind a fall.
HEXRELIEF_HD bool has_jump_before(const PixelView& view, int y, int first, int end) {
    const std::uint8_t* const flags = view.flags + view.index(0, y);
    std::uint8_t any = 0;
    for (int x = max_of(0, first - kFallReach_px); x < end; ++x) any |= flags[x];
    return (any & kJumpRight) != 0;
}

// Of a pixel in the fit, by what it is from where the vertices begin. Those behind a low fall count in full:
// there the beginning is what may be wrong.
HEXRELIEF_HD double fit_weight(double residual, bool behind_low_fall) {
    return behind_low_fall ? kFallWeight : huber_weight(residual, kFitTolerance_px);
}

// Of a pixel between two falls to its left and right, as rims that lie on half a pixel have them: the near
// surface would reach over both to be seen in that one column, and no triangle is as narrow. It is left to
// the farther surface and takes its disparity; all others keep their own, and so do parts of longer slopes.
// From the row's disparities two pixels around, 0 = none there.
HEXRELIEF_HD float between_falls(float before2, float before, float own, float after, float after2,
                                 float least) {
    const bool falls = (after > 0) & (before - own > least) & (own - after > least),
               low = own - after < kMostFall_px,
               goes_on = (before2 - before > least) | ((after2 > 0) & (after - after2 > least));
    return falls & low & !goes_on ? after : own;
}

// Falls that count there: above the jump that is given, 0 = none is.
HEXRELIEF_HD float least_fall(float max_jump_px) {
    return max_jump_px > 0 ? max_jump_px : kLeastFall_px;
}

}  // namespace hexrelief::step
