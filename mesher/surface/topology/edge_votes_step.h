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

// What two neighbouring pixels, one in either of two triangles, say about the edge between these: 1 that it
// is open, -1 that it is closed, 0 nothing. own, other: whether each lies on its triangle's label. parted:
// whether a discontinuity lies between them. Without branches.
HEXRELIEF_HD int pair_vote(bool own, bool other, bool parted) {
    const int both = own & other;
    return parted ? both : -both;
}

// Adds the vote of a pair. own, other: the pixels' triangle ids; own_id: what that of a pixel on the own
// triangle's label is; neighbours: the triangles across the edges, -1 = none.
template <typename Neighbours>
HEXRELIEF_HD void add_vote(EdgeVotes& votes, const Neighbours& neighbours, std::uint32_t own_id,
                           std::uint32_t own, std::uint32_t other, bool parted) {
    const int vote = pair_vote(own == own_id, is_on_label(other), parted);
    if (vote == 0) return;
    HEXRELIEF_UNROLL
    for (int k = 0; k < 3; ++k) {
        if (neighbours[k] < 0 || !belongs(other, static_cast<std::uint32_t>(neighbours[k]))) continue;
        votes.open[k] += vote > 0;
        votes.closed[k] += vote < 0;
        return;
    }
}

// Whether a triangle's edges are closed without a vote. plain: whether a triangle holds pixels that hang
// together with no discontinuity beside any of them.
//
// Where pairs of pixels lie along an edge between plain triangles, this is what they vote, as long as the
// triangles do not overlap: a plain triangle is one connected component, so that all its pixels lie on its
// label, and the discontinuity between two pixels would be a flag of one of them. So every pair votes -1.
// Where no pair lies along it, as beside slivers, this is the rule.
HEXRELIEF_HD bool is_closed_without_vote(bool plain, const bool neighbours_plain[3]) {
    return plain & neighbours_plain[0] & neighbours_plain[1] & neighbours_plain[2];
}

}  // namespace hexrelief::step
