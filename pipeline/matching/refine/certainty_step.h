// Whether the right picture's colours confirm on which side of a discontinuity nearby a pixel lies. The
// windows of costs carry a near surface's disparity beyond its contour, alike in both views, so the
// left-right check passes there.
#pragma once

#include <cstdint>

#include "pipeline/base/host_device.h"
#include "pipeline/matching/refine/consistency_step.h"
#include "pipeline/matching/refine/match_color_step.h"
#include "pipeline/matching/refine/side_step.h"

namespace hexrelief::step {

// The sides of the discontinuities in the block of a pixel and the eight blocks around it are its sides.
inline constexpr int kSidesBlock_px = 8;
HEXRELIEF_HD constexpr Sides no_sides() {
    return {INT16_MAX, -1};
}

HEXRELIEF_HD Sides both(const Sides& a, const Sides& b) {
    return {a.farthest < b.farthest ? a.farthest : b.farthest, a.nearest > b.nearest ? a.nearest : b.nearest};
}

enum class Certainty : std::uint8_t { wrong, undecided, right };
inline constexpr int kConfirmed = 7;  // by which the own side's difference of colours must be smaller
// The difference of a side that is hidden from the right camera, which therefore has no match.
inline constexpr int kHiddenDifference = 40;

// Returns how certain a pixel's disparity is. difference(disparity): difference between the pixel's colour
// and that of its match in the right picture. A pixel without a possible other side is certain, and so is one
// whose own surface the right picture does not show.
template <typename Difference>
HEXRELIEF_HD Certainty certainty(const RowSite& site, int own, const Sides& sides,
                                 const Difference& difference) {
    const auto hidden = [&](int disparity) {
        return is_hidden(site.nearest_seen[matching_column(site.x, site.min_px, disparity)], disparity);
    };
    int rival = INT32_MAX;
    const std::int16_t others[2] = {sides.farthest, sides.nearest};
    for (const std::int16_t other : others) {
        if (!is_possible_side(site, own, other)) continue;
        const int here = hidden(other) ? kHiddenDifference : difference(other);
        rival = here < rival ? here : rival;
    }
    if (rival == INT32_MAX || !is_in_right(site.x, site.width, site.min_px, own) || hidden(own))
        return Certainty::right;
    const int of_own = difference(own);
    return of_own <= rival - kConfirmed   ? Certainty::right
           : of_own >= rival + kConfirmed ? Certainty::wrong
                                          : Certainty::undecided;
}

}  // namespace hexrelief::step
