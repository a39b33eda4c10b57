// What another camera sees and the surface so far does not show.
#pragma once

#include "pipeline/data/disparity_map.h"
#include "pipeline/stages/other_views/view_place.h"

namespace hexrelief::stages {

// A view with the part of it that is missing in a surface.
struct OtherView {
    ViewPlace place;
    DisparityMap map;      // of the whole view, in its px
    DisparityMap missing;  // the same at the pixels that the surface leaves open, with a border of one pixel
                           // that joins the surface; all others are unknown
    Image picture;         // of the whole view, at any size
};

// Returns the pair seen in a mirror, which makes the right camera the left one: a matcher finds the right
// view's disparities, mirrored.
StereoPair mirrored(const StereoPair& pair);
// Returns the map mirrored.
DisparityMap mirrored(DisparityMap map);

// Sets `missing` of the right camera's view, which has its map. A disparity that would put a pixel in front
// of what the left camera sees there is wrong: the pixel gets the farther of the surfaces beside it in its
// row. mesh: the left view's surface; in_left: the same as the left camera sees it.
void find_missing(OtherView& right, const SurfaceMesh& mesh, const SeenSurface& in_left, int threads);

// The two pictures, at one size, and the surface as the left and the right camera see it.
struct SeenPair {
    const Image& left;
    const Image& right;
    const VisibleSurface& surface;
};

// Returns the view of a place where no camera was. Behind the silhouettes of the surface it shows nothing;
// in each row, or each column if the place is above or below the left camera, the farther of the surfaces
// beside such a gap continues in it, and its picture is mirrored into it. Gaps without a surface on both
// sides stay open.
OtherView continued_view(const ViewPlace& place, const SurfaceMesh& mesh, const SeenPair& seen, int threads);

}  // namespace hexrelief::stages
