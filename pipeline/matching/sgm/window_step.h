// Chooses which disparities of a pixel are searched, from the match of the pair at half size (coarse to fine,
// as Rothermel et al. 2012 do for SGM), and refines the best of them to 1/16 px.
#pragma once

#include "pipeline/base/host_device.h"
#include "pipeline/matching/common/bordered_raster.h"
#include "pipeline/matching/sgm/path_step.h"
#include "pipeline/matching/sgm/volume.h"

namespace hexrelief::step {

// Runs begin at multiples of this, so that paths have to move their costs at few pixels.
inline constexpr int kRunAlignment = 4;
// Radius of the neighbourhood at half size whose disparities are searched.
inline constexpr int kHalfSizeReach_px = 2;
inline constexpr int kWindowMargin_px = 6;  // margin beside these disparities, if one window holds them all

// Returns the start of the run in whose middle half this disparity lies.
HEXRELIEF_HD int run_around(int disparity) {
    return (disparity - matching::kShortRun / 2 + kRunAlignment / 2) & -kRunAlignment;
}

// Returns the window of the pixels that (x, y) at half size covers; not for a range that is searched
// completely. half: the left view's winners at half size, in 1/16 px above half_min_px, known at all pixels
// of the picture. If the neighbours' disparities are close together, the two runs are adjacent around their
// middle. Else two surfaces meet there: one run is around the pixel's own disparity, the other around the
// neighbours' most different one.
HEXRELIEF_HD matching::SearchWindow find_window(matching::DisparityView half, int half_min_px,
                                                const matching::DisparityRange& range, int x, int y) {
    const std::int16_t* const at = &half.at(x, y);
    int farthest = at[0], nearest = at[0];
    for (int j = -kHalfSizeReach_px; j <= kHalfSizeReach_px; ++j)
        for (int i = -kHalfSizeReach_px; i <= kHalfSizeReach_px; ++i) {
            const int disparity = at[j * half.stride + i];
            if (disparity < 0) continue;
            farthest = disparity < farthest ? disparity : farthest;
            nearest = disparity > nearest ? disparity : nearest;
        }
    const int offset_px = 2 * half_min_px - range.min_px;
    const auto at_full_size = [&](int disparity) { return 2 * disparity / matching::kOnePixel + offset_px; };
    const int own = at_full_size(at[0]);
    farthest = at_full_size(farthest);
    nearest = at_full_size(nearest);
    int far_run, near_run;
    if (nearest - farthest <= 2 * matching::kShortRun - 2 * kWindowMargin_px) {
        far_run = ((farthest + nearest) / 2 - matching::kShortRun + kRunAlignment / 2) & -kRunAlignment;
        near_run = far_run + matching::kShortRun;
    } else {
        const int own_run = run_around(own),
                  other_run = run_around(own - farthest > nearest - own ? farthest : nearest);
        far_run = own_run < other_run ? own_run : other_run;
        near_run = own_run < other_run ? other_run : own_run;
    }
    const auto between = [](int value, int least, int most) {
        return value < least ? least : value > most ? most : value;
    };
    const int last =
        (range.count + kRunAlignment - 1) / kRunAlignment * kRunAlignment - 2 * matching::kShortRun;
    far_run = between(far_run, 0, last);
    near_run = between(near_run, far_run + matching::kShortRun, last + matching::kShortRun);
    return {static_cast<std::int16_t>(far_run), static_cast<std::int16_t>(near_run)};
}

// Returns the index of a disparity among the pixel's entries, or -1 if it is not searched.
HEXRELIEF_HD int entry_of(const matching::SearchWindow& window, int disparity,
                          const matching::DisparityRange& range) {
    const int run = matching::run_length(range);
    if (disparity < 0 || disparity >= range.count) return -1;
    const int in_far = disparity - window.far_run, in_near = disparity - window.near_run;
    if (in_far >= 0 && in_far < run) return in_far;
    return in_near >= 0 && in_near < run ? run + in_near : -1;
}

// Refines a pixel's best disparity; returns it in 1/16 px. lower, middle, upper: the costs at disparity - 1,
// disparity and disparity + 1.
HEXRELIEF_HD int refined_winner(int disparity, int lower, int middle, int upper) {
    return matching::kOnePixel * disparity + parabola_vertex(lower, middle, upper);
}

}  // namespace hexrelief::step
