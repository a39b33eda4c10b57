// Whether the edge between two triangles is open: pairs of neighbouring pixels across it vote.
#pragma once

#include <cstdint>

#include "mesher/common/host_device.h"
#include "mesher/surface/topology/label_triangles_step.h"

namespace hexrelief::step {

// Pairs of pixels across each of a triangle's edges that say that it is open, and that it is closed: both in
// one number, so that a pair is added at once.
struct EdgeVotes {
    static constexpr std::uint64_t kOpen = 1, kClosed = std::uint64_t{1} << 32;
    std::uint64_t counts[3]{};
    HEXRELIEF_HD int open(int k) const { return static_cast<int>(counts[k] & 0xffffffffu); }
    HEXRELIEF_HD int closed(int k) const { return static_cast<int>(counts[k] >> 32); }
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
    const std::uint64_t vote = own != voters.own ? 0 : parted ? EdgeVotes::kOpen : EdgeVotes::kClosed;
    HEXRELIEF_UNROLL
    for (int k = 0; k < 3; ++k) votes.counts[k] += other == voters.across[k] ? vote : 0;
}

// Whether a triangle's edges are closed without a vote. A triangle is plain if it has pixels, each row of
// them has a column in common with the row above, and none of them has a discontinuity on its right or below
// it.
//
// Where pairs of pixels lie along an edge between plain triangles, this is what they vote, as long as the
// triangles do not overlap: a plain triangle is one connected component, so that all its pixels lie on its
// label, and a discontinuity between two pixels would lie on the right of one of them or below it. So every
// pair votes for a closed edge. Where no pair lies along the edge, as beside slivers, this is the rule.
//
// A single edge between two plain triangles needs no count of votes either where may_differ() denies that a
// discontinuity lies between their anchors: pairs vote for a closed edge, and without pairs it is closed too.
HEXRELIEF_HD bool is_closed_without_vote(bool plain, const bool neighbours_plain[3]) {
    return plain & neighbours_plain[0] & neighbours_plain[1] & neighbours_plain[2];
}

}  // namespace hexrelief::step
