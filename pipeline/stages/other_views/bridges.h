// Bridges between the missing parts of a view.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "pipeline/stages/other_views/other_view.h"

namespace hexrelief::stages {

// A pixel of a bridge, and the pixel at its beginning whose colour it gets.
struct BridgePixel {
    std::uint32_t pixel, colour_of;
};

// Joins regions of `missing` with fewer than `least` pixels to the nearest others by bridges, 9 px wide and
// more: first on the surface, then also straight on behind nearer things. From each region a bridge is at
// most reach_px long along rows and columns, and keeps 8 px from where the surface ends in front of something
// farther. No camera sees it. Neighbours that differ by more than step_px are in two regions. here: the
// surface as a view shows it. Returns the bridges for paint_bridges().
std::vector<BridgePixel> join_regions(DisparityMap& missing, const SeenSurface& here, std::size_t least,
                                      int reach_px, double step_px);

// The view's texture shows bridges in the colours of their beginnings, which take few bytes.
void paint_bridges(OtherView& view, const std::vector<BridgePixel>& bridges);

}  // namespace hexrelief::stages
