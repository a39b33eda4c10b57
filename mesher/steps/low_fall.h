// Pixels behind a low step down to the right: next to them the other camera alone sees a few pixels of the
// farther surface, and a fit that rounds the step hides these.
#pragma once

#include <cstddef>

#include "mesher/steps/host_device.h"
#include "mesher/steps/rim.h"
#include "mesher/steps/vertex_fit.h"

namespace hexrelief::step {

inline constexpr int kFallReach_px = 2;  // of a fall to its right
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

// Of a pixel in the fit, by what it is from where the vertices begin. Those behind a low fall count in full:
// there the beginning is what may be wrong.
HEXRELIEF_HD double fit_weight(double residual, bool behind_low_fall) {
    return behind_low_fall ? kFallWeight : huber_weight(residual, kFitTolerance_px);
}

}  // namespace hexrelief::step
