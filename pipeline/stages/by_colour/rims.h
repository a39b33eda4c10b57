// Settles by colour where the near surfaces of photographs end.
#pragma once

#include "pipeline/data/disparity_map.h"
#include "pipeline/data/image.h"

namespace hexrelief::stages {

// Beside a silhouette matches err by some pixels: a halo of what is behind sticks to the nearer surface, and
// shreds of it are left behind or hang between both. Here the pixels of a band along each step of at least
// 1/225 of the longer side (of disparity, and 2 px) are open: 1/120 of the longer side on the nearer
// surface, 1/450 on the farther one. Each goes to the side from which the least steps of colour lead to it,
// if most pixels around do so as well; where colours hardly differ, the step stays where it was. What
// continues its side keeps its disparity, all else takes that side's from beside the band. Things and gaps
// narrower than the band stay, except what hangs from a nearer surface. left: the picture of the map's view
// and size; without one nothing moves. Origins and unknown pixels stay. The same for any number of threads.
DisparityMap with_rims_by_colour(DisparityMap map, const Image& left, int threads);

}  // namespace hexrelief::stages
