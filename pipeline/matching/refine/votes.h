// Weighted medians that align discontinuities with the picture's colours.
#pragma once

#include "pipeline/base/thread_pool.h"
#include "pipeline/matching/common/color_planes.h"
#include "pipeline/matching/refine/slopes.h"

namespace hexrelief::matching {

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

// Selects the pixels within 2 px (along both axes) of a step of more than 1.5 px between neighbours.
Raster<VoteWindow> near_discontinuities(const Disparities16& map, ThreadPool& pool);

// Returns the map with weighted medians at the pixels that have a window. Votes for surfaces that would hide
// what the right camera sees are not counted.
Disparities16 take_votes(const VoteInput& input, const Raster<VoteWindow>& windows, ThreadPool& pool);

}  // namespace hexrelief::matching
