// The weight of a pixel as a voter.
#pragma once

#include <cstdint>

#include "pipeline/base/host_device.h"
#include "pipeline/matching/refine/certainty_step.h"
#include "pipeline/matching/refine/consistency_step.h"
#include "pipeline/matching/refine/match_color_step.h"
#include "pipeline/matching/refine/vote_step.h"

namespace hexrelief::step {

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
