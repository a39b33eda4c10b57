// Weighted medians that align discontinuities with the picture's colours.
#pragma once

#include "pipeline/base/thread_pool.h"
#include "pipeline/matching/common/color_planes.h"
#include "pipeline/matching/refine/slopes.h"

namespace hexrelief::matching {

struct SideInput {
    const Disparities16& map;
    const ColorPlanes &left, &right;  // with equal numbers of channels
    const Raster<std::int32_t>& nearest_seen;
    int min_px;
};

// Returns the map, in which pixels beside a discontinuity may have taken a neighbour's disparity.
Disparities16 choose_sides(const SideInput& input, ThreadPool& pool);

// The window that a pixel's median is taken over.
enum class VoteWindow : std::uint8_t { none, near, hole };

struct VoteInput {
    const Disparities16& map;  // without unknown pixels
    const Slopes& slopes;
    const ColorPlanes& colors;
    const ColorPlanes& hole_colors;  // blurred, for windows `hole`
    const Raster<std::int32_t>& nearest_seen;
    const Raster<std::uint8_t>& weights;  // weights of pixels as voters, 0..6
    int min_px;
};

// Selects the pixels within 1 px (along both axes) of those with a step of more than 1.5 px to a neighbour.
Raster<VoteWindow> near_discontinuities(const Disparities16& map, ThreadPool& pool);

struct VoterInput {
    const Disparities16& map;
    const PairColors& colors;
    const Raster<std::int32_t>& nearest_seen;  // see TrustedMatches
    int min_px;
};
// Returns the weights of pixels as voters in the first round (see voter_step.h). matched: 1 = matched.
Raster<std::uint8_t> first_round_weights(const VoterInput& input, const Raster<std::uint8_t>& matched,
                                         ThreadPool& pool);
// Returns the weights in a later round.
Raster<std::uint8_t> later_weights(const VoterInput& input, ThreadPool& pool);
// Gives the window `hole` to pixels that are holes by their weights of the first round.
void open_holes(const Raster<std::uint8_t>& weights, Raster<VoteWindow>& windows, ThreadPool& pool);

// Returns the map with weighted medians at the pixels that have a window. Votes for surfaces that would hide
// what the right camera sees are not counted.
Disparities16 take_votes(const VoteInput& input, const Raster<VoteWindow>& windows, ThreadPool& pool);

}  // namespace hexrelief::matching
