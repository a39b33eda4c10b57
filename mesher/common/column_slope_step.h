// Tells steps down a column that belong to one surface, such as a floor seen at a grazing angle, from
// silhouettes. Both cameras see such a surface at any slope.
#pragma once

#include <cstddef>

#include "mesher/common/surface_thresholds_step.h"
#include "pipeline/base/host_device.h"

namespace hexrelief::step {

HEXRELIEF_HD float distance(float a, float b) {
    return a < b ? b - a : a - b;
}

// True if a vertical step is hardly higher than the steps around it. Each of these counts as at most
// kSlopeMostStep times this one's height, because one high step makes no slope. above, below: number of rows
// above and below the two of the step.
HEXRELIEF_HD bool is_like_steps_around(const float* d, std::ptrdiff_t next, int above, int below,
                                       float least) {
    const int up = min_of(above, kSlopeReach_px), down = min_of(below, kSlopeReach_px);
    const float upper = d[0], lower = d[next], height = distance(upper, lower),
                most = kSlopeMostStep * height;
    if (up == 0 || down == 0 || !(d[-up * next] > 0) || !(upper > 0) || !(lower > 0) ||
        !(d[(1 + down) * next] > 0))
        return false;
    const float sign = lower > upper ? 1.0f : -1.0f;
    float over = 0, under = 0;
    for (int k = 0; k < kSlopeReach_px; ++k) {
        const auto step = [&](std::ptrdiff_t from, bool counts) {
            const float* const at = d + (counts ? from * next : 0);
            return counts ? clamp_to(sign * (at[next] - at[0]), -most, most) : 0.0f;
        };
        over += step(-1 - k, k < up);
        under += step(1 + k, k < down);
    }
    const float slope = min_of(over / static_cast<float>(up), under / static_cast<float>(down));
    return height - kSlopeShare * max_of(0.0f, slope) <= least;
}

// The least-squares line through the pixels of a column on one side of a step.
struct ColumnLine {
    int count;     // of pixels
    float first;   // px: disparity of the line at the pixel beside the step
    float slope;   // px per row, away from the step
    float off_px;  // distance of that pixel from the line

    // Returns the line's disparity halfway between the two pixels of the step.
    HEXRELIEF_HD float at_step() const { return first - 0.5f * slope; }
};

// Returns the line from the pixel at d[0] on along `away`. It ends before an unknown pixel and before a step
// of more than most_px. available: pixels of the column beyond the first.
HEXRELIEF_HD ColumnLine line_away(const float* d, std::ptrdiff_t away, int available, float most_px) {
    int n = 1;
    float sum = 0, moment = 0;  // of the differences from the first pixel
    for (; n < kLineReach_px && n <= available; ++n) {
        const float own = d[n * away];
        if (!(own > 0) || distance(own, d[(n - 1) * away]) > most_px) break;
        const float rise = own - d[0];
        sum += rise;
        moment += static_cast<float>(n) * rise;
    }
    if (n < 2) return {n, d[0], 0, 0};
    // The sums of 0 .. n - 1 and of their squares
    const float ones = static_cast<float>(n), places = static_cast<float>(n * (n - 1) / 2),
                squares = static_cast<float>((n - 1) * n * (2 * n - 1) / 6);
    const float slope = (ones * moment - places * sum) / (ones * squares - places * places);
    const float off = (sum - slope * places) / ones;
    return {n, d[0] + off, slope, off < 0 ? -off : off};
}

// True if the surfaces on both sides of a vertical step, continued as lines, meet there; or if both slope its
// way and it is a fold, which hides no more than a few rows of the slope.
HEXRELIEF_HD bool is_explained_by_lines(const float* d, std::ptrdiff_t next, int above, int below) {
    const float upper = d[0], lower = d[next], height = distance(upper, lower);
    if (!(upper > 0) || !(lower > 0)) return false;
    const ColumnLine over = line_away(d, -next, above, height),
                     under = line_away(d + next, next, below, height);
    if (min_of(over.count, under.count) < kLineLeast_px || max_of(over.off_px, under.off_px) > kLineOff_px)
        return false;
    const float sign = lower > upper ? 1.0f : -1.0f, rise_over = -sign * over.slope,
                rise_under = sign * under.slope, least_rise = min_of(rise_over, rise_under);
    const float gap = sign * (under.at_step() - over.at_step());
    return (least_rise > kMeetingSlope && gap <= kMeeting_px) ||
           (least_rise > kFoldSlope && gap <= 0.5f * kFoldRows * (rise_over + rise_under));
}

// True if a vertical step of more than `least` px, from d[0] to d[next], lies within one surface. above,
// below: number of rows above and below the two of the step.
HEXRELIEF_HD bool is_slope(const float* d, std::ptrdiff_t next, int above, int below, float least) {
    return is_like_steps_around(d, next, above, below, least) || is_explained_by_lines(d, next, above, below);
}

}  // namespace hexrelief::step
