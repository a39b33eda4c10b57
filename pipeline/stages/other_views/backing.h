// A coarse surface behind all silhouettes of a view.
#pragma once

#include <cstddef>

#include "pipeline/stages/other_views/other_view.h"

namespace hexrelief::stages {

// Returns the left view, 320 px wide or high at most. Missing is what lies more than 1 px in front of the
// farthest surface around it, within a tenth of the longer side of a silhouette, but for the view's border:
// the view's map shows that surface, smoothed, and its colour is the mean of what is far there. So what
// nothing continues behind silhouettes is closed. Near the view's border it comes forward to the surface
// there, so that cameras up to `baselines` beside the left one do not see it beyond. here: the surface as the
// left view shows it. picture: the left one, of its size; empty = none. It is no farther than least_px. The
// same for any number of threads.
OtherView backing_of(const SeenSurface& here, const Image& picture, double baselines, double least_px,
                     int threads);
// Joins its parts of fewer than `least` px of the left view to others by bridges along the surface of its map
// (join_regions()), at most reach_px of its own long.
void join_backing(OtherView& backing, std::size_t least, int reach_px);

}  // namespace hexrelief::stages
