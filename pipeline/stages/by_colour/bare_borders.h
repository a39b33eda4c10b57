// Gives bare bands of what is farther, over which nearer things have grown, back to it.
#pragma once

#include "pipeline/data/disparity_map.h"
#include "pipeline/data/image.h"
#include "pipeline/stages/by_colour/picture_kinds.h"

namespace hexrelief::stages {

// A wall without texture matches nothing by itself, so that matches of a thing in front of it spread over a
// band of the wall beside the thing. From each step in depth that has no contour in the picture, levels are
// flooded here into the nearer surface, over like colours, a 40th of the longer side at most. A region that
// is reached and ends at a contour along most of its border, with more of the nearer surface behind that, is
// given to the farther surface. Where the flood leaks, what it reached from there stays, and all else is
// judged again. Origins and unknown pixels stay. left: the picture of the map's view and size. The same for
// any number of threads.
//
// A rectified pair's border moves on by a pixel towards the contour. Photographs, whose nearer things were
// widened (with_wider_near()), keep the pixels at the contour, as their colours are mixed, with the nearer
// surface; and their far end, as the sky is, is followed an 8th of the longer side and through its clouds,
// where that gives it a thousandth of the picture or more.
DisparityMap with_bare_borders_behind(DisparityMap map, const Image& left, Pictures pictures, int threads);

}  // namespace hexrelief::stages
