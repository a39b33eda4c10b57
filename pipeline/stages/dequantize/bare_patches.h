// Puts bare patches back that were filled from a nearer thing beside them.
#pragma once

#include "pipeline/data/disparity_map.h"

namespace hexrelief::stages {

// A bare wall has no matches but where something on it shows, and is filled from what is nearest in the
// picture: a head in front of it. Here levels are flooded from the surely matched pixels, those that matched
// ones surround, along the smallest differences of colour. Where bare pixels are thus led to a farther
// surface than they have, over a thousandth of the picture and by a 16th of the map's range on an average,
// they follow that surface, unless the right picture's colours fit worse there. pair: pictures of the map's
// size. Maps without origins, unknown pixels and origins stay.
DisparityMap with_bare_patches_behind(DisparityMap map, const StereoPair& pair);

}  // namespace hexrelief::stages
