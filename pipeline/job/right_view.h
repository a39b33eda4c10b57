// Makes the view of a pair's right camera, for what the left one does not see (pipeline/stages/other_views).
#pragma once

#include "pipeline/job/input.h"
#include "pipeline/job/relief.h"

namespace hexrelief::job {

// Returns the right view of a pair, its picture in the left one's light. It has no map yet. The picture at
// its original size is moved out of the pair.
stages::OtherView unmatched_right_view(InputPair& pair, const stages::FoundRange& range, int threads);

// Does the same with its map, by both views' maps of a program of the user's.
stages::OtherView right_view_of_program(InputPair& pair, const stages::ViewMaps& maps,
                                        const stages::FoundRange& range, int threads);

// Adds the place of the right view, and its mask; makes its map, if it has one, fit the left view's: counted
// from infinity, ended by the backdrop, without the background, smoothed.
void complete_right_view(stages::OtherView& right, const LeftView& left, const DisparityResult& disparity,
                         const readers::PixelMask& mask, int threads);

// Returns the map of the right view, which needs its place, by the surface and the left view's background:
// what neither of them shows lies on the planes of those around it, on whose side its colours tell. here: the
// surface as the right view shows it. All is unknown if both show nothing.
DisparityMap map_by_surface(const stages::OtherView& right, const stages::SeenSurface& here,
                            const LeftView& left, int threads);

// Makes what lies below background_px, in px, or is not shown by the view's picture, unknown in its map.
void drop_background(stages::OtherView& right, float background_px);

}  // namespace hexrelief::job
