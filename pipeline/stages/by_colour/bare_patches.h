// Puts bare patches back that were filled from a nearer thing beside them, and continues surfaces beyond the
// right picture's right end.
#pragma once

#include <cstdint>
#include <vector>

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

// Of two photographs that are turned until their rows agree, the right one may end before the left view does.
// What would lie beyond its end matches nothing, or what is nearer and still inside, and is filled from
// nearer things. Here what lies right of its row's last surely matched pixel is flooded from such pixels
// along the smallest differences of colour, and takes the disparity that it is led from where that lies
// beyond the right picture, or within a 20th of the longer side of its end. What such a pixel more than a
// 10th away leads to is no nearer than what pixels that were filled inside lead to. left: as above. is_seen:
// of the right picture, the map's size, 1 = shows something; empty = all. Maps without origins, unknown
// pixels, and matched ones beside sure ones stay.
DisparityMap continued_at_right_end(DisparityMap map, const Image& left,
                                    const std::vector<std::uint8_t>& is_seen, int threads);

}  // namespace hexrelief::stages
