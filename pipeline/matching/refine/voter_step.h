// What a pixel weighs as a voter in the first round of votes.
#pragma once

#include <cstdint>

#include "mesher/common/host_device.h"
#include "pipeline/matching/refine/consistency_step.h"
#include "pipeline/matching/refine/match_color_step.h"
#include "pipeline/matching/refine/vote_step.h"

namespace hexrelief::step {

// Filled pixels have little weight, as those of one colour were filled alike and would vote for themselves;
// more if the right picture has their colours where their disparity leads. Beyond its left edge there may be
// no others.
inline constexpr std::uint8_t kFilledWeight = 1, kBeyondEdgeWeight = 3, kAlikeWeight = 4;
inline constexpr int kAlike = 9 * 15;  // the largest difference of such colours, a sum over 3x3 pixels

// Whether the right camera may see the pixel where its disparity leads.
HEXRELIEF_HD bool may_be_seen(const RowSite& site, int disparity) {
    if (disparity < 0 || !is_in_right(site.x, site.width, site.min_px, disparity)) return false;
    const std::int32_t nearest = site.nearest_seen[matching_column(site.x, site.min_px, disparity)];
    return !hides(nearest, disparity) && !is_hidden(nearest, disparity);
}

// difference(): of the colours of 3x3 pixels around it and of those that the right picture has there, in
// colour: levels of grey are alike too often.
template <typename Difference>
HEXRELIEF_HD std::uint8_t filled_weight(const RowSite& site, int disparity, bool in_color,
                                        const Difference& difference) {
    if (beyond_left_edge(site.x, site.min_px, disparity)) return kBeyondEdgeWeight;
    return in_color && may_be_seen(site, disparity) && difference() <= kAlike ? kAlikeWeight : kFilledWeight;
}

}  // namespace hexrelief::step
