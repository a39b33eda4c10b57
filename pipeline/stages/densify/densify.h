// Fills a map of scattered measurements, guided by the picture if there is one, and cuts the blurred steps of
// a map along the picture's edges.
#pragma once

#include "pipeline/data/disparity_map.h"

namespace hexrelief::stages {

// Returns a dense map. sparse: see Sparsity::is_sparse(). left: the picture of the map's view and size, or
// empty. Unknown pixels surrounded by measurements get the disparity of one of the surfaces around them;
// others stay unknown. Known pixels keep their disparities. The origins are matched for pixels known before,
// filled for those filled here. The result is the same for any number of threads (>= 1).
DisparityMap densify(const DisparityMap& sparse, const Image& left, int threads);

// Returns a map of surfaces without its holes: each unknown pixel lies on the plane of one of the surfaces
// around it. map: known pixels in at least one place. left, the origins and the result are as those of
// densify().
DisparityMap fill_holes(const DisparityMap& map, const Image& left, int threads);

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
