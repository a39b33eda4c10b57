// Puts bare patches on planes through their matches, if the matches and the pictures support these.
#pragma once

#include "pipeline/data/disparity_map.h"
#include "pipeline/stages/by_colour/picture_kinds.h"

namespace hexrelief::stages {

// A bare patch, where neighbours' colours hardly differ, is matched at its rim and at what little shows on
// it, and is filled from there, with what is wrong of these matches. Here a plane is fitted to the matches
// of each patch of 1/500 of a rectified pair's picture or more of which at most 9/10 is matched; of
// photographs, whose surfaces bend more, of 1/150 or more of which at most 2/5 is. If it holds most of them,
// all over the patch as far as both cameras see it, and the right picture has the patch's colours along it
// as well as along the map, what is not matched there, or matched off it, follows it, within the range of
// the map. pair: as it was matched. Origins and unknown pixels stay, as do maps without origins. The same
// for any number of threads.
DisparityMap with_planes_on_bare_patches(DisparityMap map, const StereoPair& pair, Pictures pictures,
                                         int threads);

}  // namespace hexrelief::stages
