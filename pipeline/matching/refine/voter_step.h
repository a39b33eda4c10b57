// The weight of a pixel as a voter, and how certain it is. Windows of costs carry a near surface's disparity
// beyond its contour, alike in both views, so that the left-right check passes there; only the right
// picture's colours tell on which side of a discontinuity nearby such a pixel lies.
#pragma once

#include <cstdint>

#include "pipeline/base/host_device.h"
#include "pipeline/matching/refine/consistency_step.h"
#include "pipeline/matching/refine/match_color_step.h"
#include "pipeline/matching/refine/side_step.h"
#include "pipeline/matching/refine/vote_step.h"

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

// A pixel that is not matched, or whose side is not certain, is a hole in the first round: it has a hole's
// window, and the weight of a filled pixel. That is little, because pixels of one colour were filled alike
// and would vote for themselves. They have more if the right picture has their colours at their match, and
// beyond its left edge, where there may be no other voters.
inline constexpr std::uint8_t kFilledWeight = 1, kBeyondEdgeWeight = 3, kAlikeWeight = 4;
inline constexpr int kAlike = 9 * 15;  // largest difference of similar colours, a sum over 3x3 pixels

// True if the right camera may see the pixel at its match.
HEXRELIEF_HD bool may_be_seen(const RowSite& site, int disparity) {
    if (disparity < 0 || !is_in_right(site.x, site.width, site.min_px, disparity)) return false;
    const std::int32_t nearest = site.nearest_seen[matching_column(site.x, site.min_px, disparity)];
    return !hides(nearest, disparity) && !is_hidden(nearest, disparity);
}

// Returns a hole's weight in the first round. difference(): difference of colours between the 3x3 pixels
// around it and those around its match; used only in colour, because levels of grey are too often alike.
template <typename Difference>
HEXRELIEF_HD std::uint8_t filled_weight(const RowSite& site, int disparity, bool in_color,
                                        const Difference& difference) {
    if (beyond_left_edge(site.x, site.min_px, disparity)) return kBeyondEdgeWeight;
    return in_color && may_be_seen(site, disparity) && difference() <= kAlike ? kAlikeWeight : kFilledWeight;
}

// True if a pixel is a hole, by its weight in the first round.
HEXRELIEF_HD bool is_hole(std::uint8_t weight) {
    return weight != kMatchedWeight;
}

// Returns a pixel's weight in later rounds.
HEXRELIEF_HD std::uint8_t later_weight(Certainty certainty) {
    constexpr std::uint8_t kWrongWeight = 1, kUndecidedWeight = 2;
    return certainty == Certainty::right       ? kMatchedWeight
           : certainty == Certainty::undecided ? kUndecidedWeight
                                               : kWrongWeight;
}

}  // namespace hexrelief::step
