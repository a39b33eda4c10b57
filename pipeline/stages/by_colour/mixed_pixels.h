// Gives pixels between two surfaces, and scraps without matches, to the surfaces around them.
#pragma once

#include "pipeline/data/disparity_map.h"
#include "pipeline/data/image.h"

namespace hexrelief::stages {

// Pixels at a silhouette whose colours are mixed are matched somewhere between both surfaces, which would be
// meshed as shreds. Each region of fewer than 60 pixels (neighbours at most 1 px apart) that has both nearer
// and farther neighbours is given to the surfaces around it: a pixel follows the neighbour whose colour is
// most like its own.
//
// So are the filled pixels of strips along a row or a column, up to 1/200 of the longer side wide, with what
// is farther on both sides; and if scraps go, regions of up to 1/1700 of the picture in front of something,
// of which less than half was matched: both were filled from a nearer thing. left: the picture of the map's
// view and size. Origins and unknown pixels stay.
enum class Scraps { stay, go };
DisparityMap without_mixed_pixels(DisparityMap map, const Image& left, Scraps scraps);

// Widens nearer surfaces over what is farther beside them by 1/450 of the longer side, at least a pixel. The
// mixed pixels at a silhouette, and the error of its place, would draw the nearer thing's contour on what is
// behind it as soon as the mesh is turned; a fringe of the nearer thing in the farther colours is hardly
// seen. The left picture stays as it is. Origins and unknown pixels stay. The same for any number of threads.
DisparityMap with_wider_near(DisparityMap map, int threads);

}  // namespace hexrelief::stages
