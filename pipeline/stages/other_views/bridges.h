// Bridges between the missing parts of a view.
#pragma once

#include <cstddef>

#include "pipeline/stages/other_views/other_view.h"

namespace hexrelief::stages {

// Joins regions of `missing` with fewer than `least` pixels to the nearest others by bridges, 9 px wide and
// more: first on the surface, then also straight on behind nearer things. From each region a bridge is at
// most reach_px long along rows and columns, and keeps 8 px from where the surface ends in front of something
// farther. No camera sees it: the view's texture shows it in the colour of its beginning, which takes few
// bytes. Neighbours that differ by more than step_px are in two regions. here: the surface as the view shows
// it.
void join_regions(OtherView& view, const SeenSurface& here, std::size_t least, int reach_px, double step_px);

}  // namespace hexrelief::stages
