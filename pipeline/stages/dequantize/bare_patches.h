// Puts bare patches back that were filled from a nearer thing beside them.
#pragma once

#include "pipeline/data/disparity_map.h"
#include "pipeline/data/image.h"

namespace hexrelief::stages {

// A bare wall has no matches but where something on it shows, and is filled from what is nearest in the
// picture: a head in front of it. Here levels are flooded from the surely matched pixels, those that matched
// ones surround, along the smallest differences of colour. Where a bare pixel is thus led to a farther
// surface than it has, over a thousandth of the picture and by half of the map's range on an average, it
// follows that surface. left: the picture of the map's view and size. Maps without origins, unknown pixels
// and origins stay.
DisparityMap with_bare_patches_behind(DisparityMap map, const Image& left, int threads);

}  // namespace hexrelief::stages
