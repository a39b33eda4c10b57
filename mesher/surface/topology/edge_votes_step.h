// Whether the edge between two triangles is open: pairs of neighbouring pixels across it vote.
#pragma once

#include <cstdint>

#include "mesher/common/host_device.h"
#include "mesher/surface/topology/label_triangles_step.h"

namespace hexrelief::step {

// Pairs of pixels across each of a triangle's edges that say that it is open, and that it is closed.
struct EdgeVotes {
    int open[3]{}, closed[3]{};
};

// The triangle ids of pixels that vote about a triangle's edges: one in the triangle, and one in the
// neighbour across each edge, both on their triangles' labels.
struct VoterIds {
    std::uint32_t own, across[3];
};

// neighbours: the triangles across the edges, -1 = none. The lower triangle of an edge counts its votes;
// those of a neighbour across two edges count for the first.
template <typename Neighbours>
HEXRELIEF_HD VoterIds voters_of(std::uint32_t t, const Neighbours& neighbours) {
    constexpr std::uint32_t kNoId = 1;  // no pixel's
    VoterIds ids{triangle_id(t, true), {kNoId, kNoId, kNoId}};
    HEXRELIEF_UNROLL
    for (int k = 0; k < 3; ++k) {
        const std::int32_t n = neighbours[k];
        const bool again = (k > 0 && n == neighbours[0]) || (k > 1 && n == neighbours[1]);
        if (n > static_cast<std::int32_t>(t) && !again)
            ids.across[k] = triangle_id(static_cast<std::uint32_t>(n), true);
    }
    return ids;
}

// Adds the vote of a pair of neighbouring pixels with these triangle ids: that the edge between their
// triangles is open if a discontinuity parts them, else that it is closed. Without branches, which could not
// be foreseen.
HEXRELIEF_HD void add_vote(EdgeVotes& votes, const VoterIds& voters, std::uint32_t own, std::uint32_t other,
                           bool parted) {
    const bool votes_at_all = own == voters.own;
    HEXRELIEF_UNROLL
    for (int k = 0; k < 3; ++k) {
        const bool counts = votes_at_all & (other == voters.across[k]);
        votes.open[k] += counts & parted;
        votes.closed[k] += counts & !parted;
    }
}

// Whether a triangle's edges are closed without a vote. A triangle is plain if it has pixels, each row of
// them has a column in common with the row above, and none of them has a discontinuity on its right or below
// it.
//
// Where pairs of pixels lie along an edge between plain triangles, this is what they vote, as long as the
// triangles do not overlap: a plain triangle is one connected component, so that all its pixels lie on its
// label, and a discontinuity between two pixels would lie on the right of one of them or below it. So every
// pair votes for a closed edge. Where no pair lies along the edge, as beside slivers, this is the rule.
HEXRELIEF_HD bool is_closed_without_vote(bool plain, const bool neighbours_plain[3]) {
    return plain & neighbours_plain[0] & neighbours_plain[1] & neighbours_plain[2];
}

}  // namespace hexrelief::step
