// Connects a triangle's pixels to components, rates its pixels on other surfaces, and decides whether the
// edge between two triangles is open: pairs of neighbouring pixels across it vote.
#pragma once

#include <cmath>
#include <cstdint>

#include "mesher/common/surface_thresholds_step.h"
#include "mesher/surface/pixels/crack_edges_step.h"
#include "mesher/surface/topology/rasterize_step.h"
#include "pipeline/base/host_device.h"
#include "pipeline/data/geometry.h"

namespace hexrelief::step {

// Returns one word with a pixel's triangle and whether the pixel lies on the triangle's label; 0 stands for
// no triangle. If triangles overlap, as in a folded lattice, the highest word wins, so that the order of
// work does not matter.
HEXRELIEF_HD std::uint32_t triangle_id(std::uint32_t triangle, bool on_label) {
    return 2 * (triangle + 1) + on_label;
}
// True if the id is of this triangle.
HEXRELIEF_HD bool belongs(std::uint32_t id, std::uint32_t triangle) {
    return id / 2 == triangle + 1;
}

// Returns the pixel at the centre of a triangle, for one that has no pixels.
HEXRELIEF_HD std::uint32_t middle_pixel(const PixelView& view, const Vec2f& a, const Vec2f& b,
                                        const Vec2f& c) {
    const int x = static_cast<int>((a.x + b.x + c.x) / 3), y = static_cast<int>((a.y + b.y + c.y) / 3);
    return static_cast<std::uint32_t>(
        view.index(clamp_to(x, 0, view.width - 1), clamp_to(y, 0, view.height - 1)));
}

// Returns the error of a pixel on another surface than its triangle's, whose disparity is `mean`: the squared
// difference, weighted by the cube of the pixel's disparity over the map's largest one, `nearest`.
HEXRELIEF_HD double outlier_error(float disparity, double mean, double nearest) {
    const double d = disparity;
    const double e = d > 0 && mean > 0 ? min_of(std::fabs(d - mean), kMostError_px) : kMostError_px;
    const double share = (d > 0 ? d : kHoleWeight * mean) / nearest;
    return share * share * share * e * e * (d > 0 && d < mean ? kCoveredWeight : 1.0);
}

// True if two runs have a column in common and `lower` is in the next row.
HEXRELIEF_HD bool lie_above(const surface::PixelRun& upper, const surface::PixelRun& lower) {
    return upper.y + 1 == lower.y && upper.first < lower.end && lower.first < upper.end;
}

// The columns of two pixels that touch at a corner: the first or last one of a run, and a pixel in
// the other run's row.
struct Diagonal {
    int upper_x, lower_x;
};

// Returns diagonal k, 0 <= k < 4, of two runs.
HEXRELIEF_HD Diagonal diagonal_at(int k, const surface::PixelRun& upper, const surface::PixelRun& lower) {
    return k == 0   ? Diagonal{upper.end - 1, upper.end}
           : k == 1 ? Diagonal{upper.first, upper.first - 1}
           : k == 2 ? Diagonal{lower.first - 1, lower.first}
                    : Diagonal{lower.end, lower.end - 1};
}

// True if both pixels of a diagonal belong to the runs and are connected, because one of the two ways
// around their corner meets no discontinuity. (The other way leads through the triangle's own pixels,
// which connects them anyway.)
template <typename View>
HEXRELIEF_HD bool is_free_diagonal(const View& view, int k, const surface::PixelRun& upper,
                                   const surface::PixelRun& lower) {
    const Diagonal pair = diagonal_at(k, upper, lower);
    const bool across_first = k < 2;  // then down
    const int down = across_first ? pair.lower_x : pair.upper_x;
    if (across_first ? down < lower.first || down >= lower.end : down < upper.first || down >= upper.end)
        return false;
    const auto across = view.index(min_of(pair.upper_x, pair.lower_x), across_first ? upper.y : lower.y);
    return !((view.flags[across] & kDiscontinuityRight) |
             (view.flags[view.index(down, upper.y)] & kDiscontinuityDown));
}

// Calls link(i, j) for each two pixels of the runs that are connected diagonally; `lower` is in the next row.
template <typename Link>
HEXRELIEF_HD void each_diagonal(const PixelView& view, const surface::PixelRun& upper,
                                const surface::PixelRun& lower, const Link& link) {
    HEXRELIEF_UNROLL
    for (int k = 0; k < 4; ++k) {
        if (!is_free_diagonal(view, k, upper, lower)) continue;
        const Diagonal pair = diagonal_at(k, upper, lower);
        link(static_cast<std::uint32_t>(view.index(pair.upper_x, upper.y)),
             static_cast<std::uint32_t>(view.index(pair.lower_x, lower.y)));
    }
}

// The columns of the nearest pixels of two runs that do not touch, as thin triangles have them.
struct Bridge {
    int upper_x, lower_x;
};

HEXRELIEF_HD Bridge bridge_between(const surface::PixelRun& upper, const surface::PixelRun& lower) {
    if (lower.end <= upper.first) return {upper.first, lower.end - 1};
    // a column of both runs, unless the lower one lies to the right
    const int x = max_of(upper.first, lower.first);
    return {min_of(x, upper.end - 1), x};
}

// Returns the path between the centres of two pixels.
HEXRELIEF_HD Way way_between_centres(int x0, int y0, int x1, int y1) {
    const auto middle = [](int at) { return static_cast<float>(at) + 0.5f; };
    return way_between(middle(x0), middle(y0), middle(x1), middle(y1));
}

// True if the disparities of two triangles' anchors i and j differ by a discontinuity, which is necessary for
// one to lie between them; it decides about an edge without pairs.
HEXRELIEF_HD bool may_differ(const PixelView& view, std::uint32_t i, std::uint32_t j,
                             float discontinuity_px) {
    return is_discontinuity(view.disparity[i], view.disparity[j], discontinuity_px);
}
// Returns the path between the centres of pixels i and j.
HEXRELIEF_HD Way way_between_pixels(const PixelView& view, std::uint32_t i, std::uint32_t j) {
    const std::uint32_t w = static_cast<std::uint32_t>(view.width);
    return way_between_centres(static_cast<int>(i % w), static_cast<int>(i / w), static_cast<int>(j % w),
                               static_cast<int>(j / w));
}

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
