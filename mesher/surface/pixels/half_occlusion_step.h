// Low half-occlusion steps: from near to far, left to right. Beside them lies a strip of the farther surface,
// a few pixels wide, that only the right camera sees. A nearer surface that reaches a little too far, or a
// fit that rounds the step, would hide it.
#pragma once

#include <cstddef>
#include <cstdint>

#include "mesher/common/surface_thresholds_step.h"
#include "mesher/surface/pixels/crack_edges_step.h"
#include "pipeline/base/host_device.h"

namespace hexrelief::step {

// True if the step between two neighbours of a row is a low half-occlusion step.
HEXRELIEF_HD bool is_low_half_occlusion(float left, float right) {
    return (right > 0) & (left > right) & (left - right < kLowHalfOcclusion_px);
}

// True if the last discontinuity to the left of (x, y), within kHalfOcclusionReach_px, is
// a low half-occlusion step.
HEXRELIEF_HD bool is_behind_low_half_occlusion(const PixelView& view, int x, int y) {
    const std::size_t i = view.index(x, y);
    for (int k = 1; k <= kHalfOcclusionReach_px && k <= x; ++k) {
        if (!(view.flags[i - k] & kDiscontinuityRight)) continue;
        return is_low_half_occlusion(view.disparity[i - k], view.disparity[i - k + 1]);
    }
    return false;
}

// True if a discontinuity to the right neighbour lies among pixels first .. end - 1 of a row or shortly
// before them; otherwise none of them is behind a half-occlusion step.
HEXRELIEF_HD bool has_discontinuity_before(const PixelView& view, int y, int first, int end) {
    const std::uint8_t* const flags = view.flags + view.index(0, y);
    std::uint8_t any = 0;
    for (int x = max_of(0, first - kHalfOcclusionReach_px); x < end; ++x) any |= flags[x];
    return (any & kDiscontinuityRight) != 0;
}

// Returns the disparity of a pixel after low steps of single-pixel width are removed. A pixel between two
// half-occlusion steps, on its left and right, takes the disparity on its right, that of the farther surface:
// maps have such pixels where a silhouette runs through a pixel's middle, and no triangle is as narrow. All
// others keep their own disparity, and so do parts of longer slopes. The arguments are the row's disparities
// up to two pixels away, 0 beyond its ends.
HEXRELIEF_HD float between_half_occlusions(float before2, float before, float own, float after, float after2,
                                           float least) {
    const bool half_occlusions = (after > 0) & (before - own > least) & (own - after > least),
               low = own - after < kLowHalfOcclusion_px,
               goes_on = (before2 - before > least) | ((after2 > 0) & (after - after2 > least));
    return half_occlusions & low & !goes_on ? after : own;
}

}  // namespace hexrelief::step
