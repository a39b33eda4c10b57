// Decides whether the edge between two triangles is open: pairs of neighbouring pixels across it vote.
#pragma once

#include <cstdint>

#include "mesher/surface/topology/label_triangles_step.h"
#include "pipeline/base/host_device.h"

namespace hexrelief::step {

// The votes on each of a triangle's edges: how many pairs of pixels say that it is open, and how many that it
// is closed. One number holds both counts, so that a vote is a single addition.
struct EdgeVotes {
    static constexpr std::uint64_t kOpen = 1, kClosed = std::uint64_t{1} << 32;
    std::uint64_t counts[3]{};
    HEXRELIEF_HD int open(int k) const { return static_cast<int>(counts[k] & 0xffffffffu); }
    HEXRELIEF_HD int closed(int k) const { return static_cast<int>(counts[k] >> 32); }
};

// The triangle ids of the pixels that vote on a triangle's edges: a pixel in the triangle and one in the
// neighbour across each edge, both on their triangles' labels.
struct VoterIds {
    std::uint32_t own, across[3];
};

// Returns the voters of triangle t. neighbours: the triangles across its edges, -1 = none. The lower triangle
// of an edge counts its votes; a neighbour across two edges votes on the first.
template <typename Neighbours>
HEXRELIEF_HD VoterIds voters_of(std::uint32_t t, const Neighbours& neighbours) {
    constexpr std::uint32_t kNoId = 1;  // an id that no pixel has
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

// Adds the vote of two neighbouring pixels with these triangle ids: the edge between their triangles is
// open if a discontinuity lies between the pixels (`parted`), else closed. It has no branches, because
// they would be unpredictable.
HEXRELIEF_HD void add_vote(EdgeVotes& votes, const VoterIds& voters, std::uint32_t own, std::uint32_t other,
                           bool parted) {
    const std::uint64_t vote = own != voters.own ? 0 : parted ? EdgeVotes::kOpen : EdgeVotes::kClosed;
    HEXRELIEF_UNROLL
    for (int k = 0; k < 3; ++k) votes.counts[k] += other == voters.across[k] ? vote : 0;
}

// True if a triangle's edges are closed without a vote. A triangle is plain if it has pixels, each
// row of them has a column in common with the row above, and none of them has a discontinuity on its
// right or below it.
//
// If pairs of pixels lie along an edge between plain triangles, their vote gives this result as well, as
// long as the triangles do not overlap: a plain triangle is one connected component, so all its pixels lie
// on its label, and a discontinuity between two pixels would lie on the right of one of them or below it.
// So every pair votes for a closed edge. If no pair lies along the edge, as beside slivers, the edge is
// closed by this rule.
//
// A single edge between two plain triangles needs no count of votes either if may_differ() excludes a
// discontinuity between their anchors: pairs vote for a closed edge, and without pairs it is closed too.
HEXRELIEF_HD bool is_closed_without_vote(bool plain, const bool neighbours_plain[3]) {
    return plain & neighbours_plain[0] & neighbours_plain[1] & neighbours_plain[2];
}

}  // namespace hexrelief::step
