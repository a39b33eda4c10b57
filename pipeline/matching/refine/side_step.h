// Decides which of two surfaces that meet at a discontinuity a pixel belongs to: the one whose match in the
// right picture has the pixel's colour. Votes decide by windows, so they can be wrong by a pixel.
#pragma once

#include <cstddef>
#include <cstdint>

#include "pipeline/base/host_device.h"
#include "pipeline/matching/refine/consistency_step.h"
#include "pipeline/matching/refine/match_color_step.h"
#include "pipeline/matching/refine/vote_step.h"

namespace hexrelief::step {

inline constexpr int kSideRounds = 2;    // each moves a discontinuity by at most a pixel
inline constexpr int kClearlyLess = 20;  // by which the other surface's difference must be smaller

// The least and the largest disparity of 3x3 pixels; unknown neighbours do not count.
struct Sides {
    std::int16_t farthest, nearest;
};
HEXRELIEF_HD Sides sides_at(const std::int16_t* at, std::ptrdiff_t stride) {
    const std::int16_t own = *at;
    Sides sides{own, own};
    for (int j = -1; j <= 1; ++j)
        for (int i = -1; i <= 1; ++i) {
            const std::int16_t neighbour = at[j * stride + i], other = neighbour < 0 ? own : neighbour;
            sides.farthest = other < sides.farthest ? other : sides.farthest;
            sides.nearest = other > sides.nearest ? other : sides.nearest;
        }
    return sides;
}

HEXRELIEF_HD bool is_possible_side(const RowSite& site, int own, int other) {
    return discontinuous(own, other) && is_in_right(site.x, site.width, site.min_px, other) &&
           !hides(site.nearest_seen[matching_column(site.x, site.min_px, other)], other);
}

// Returns the pixel's new disparity. difference(disparity): difference between the pixel's colour and that of
// its match in the right picture. If the right picture does not show the pixel's own surface, the disparity
// is unchanged, because the colours cannot tell that surface from others.
template <typename Difference>
HEXRELIEF_HD std::int16_t better_side(const RowSite& site, std::int16_t own, const Sides& sides,
                                      const Difference& difference) {
    if (!is_in_right(site.x, site.width, site.min_px, own) ||
        is_hidden(site.nearest_seen[matching_column(site.x, site.min_px, own)], own))
        return own;
    std::int16_t best = own;
    int least = difference(own) - kClearlyLess;
    const std::int16_t others[2] = {sides.farthest, sides.nearest};
    for (const std::int16_t other : others) {
        if (!is_possible_side(site, own, other)) continue;
        const int here = difference(other);
        if (here >= least) continue;
        least = here;
        best = other;
    }
    return best;
}

}  // namespace hexrelief::step
