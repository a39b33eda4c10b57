// Cuts the blurred steps of a map along the picture's edges.
#pragma once

#include "pipeline/data/disparity_map.h"

namespace hexrelief::stages {

struct SharpenedMap {
    DisparityMap map;
    double blurred_share = 0;  // of the pixels, those that lay on blurred steps; 0 = the map is as it was
};

// Networks and maps that were enlarged blur the steps between surfaces over some px, which meshes as
// curtains. A pixel lies on a blurred step if the map rises there steadily, over 3 to 16 px along a row or
// column, by at least 3 px, and several times as steeply as at both ends. In a map with more than 40 times as
// many such pixels as sharp steps, these and their neighbours are filled by fill_holes(). If that moves
// pixels to both sides of the steps alike, only those that the blur brought to the middle of a step may
// change sides. Other maps stay as they are. left: the picture of the map's view and size. What is unknown
// stays so. The result has no origins, and is the same for any number of threads (>= 1).
SharpenedMap sharpen_steps(DisparityMap map, const Image& left, int threads);

}  // namespace hexrelief::stages
