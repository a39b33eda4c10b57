// Gives pixels between two surfaces to one of these.
#pragma once

#include "pipeline/data/disparity_map.h"

namespace hexrelief::stages {

// Pixels at a silhouette whose colours are mixed are matched somewhere between both surfaces, which would be
// meshed as shreds. Each region of fewer than 60 pixels (neighbours at most 1 px apart) that has both nearer
// and farther neighbours is given to the surfaces around it: a pixel follows the neighbour whose colour is
// most like its own. left: the picture of the map's view and size. Origins and unknown pixels stay.
DisparityMap without_mixed_pixels(DisparityMap map, const Image& left);

}  // namespace hexrelief::stages
