// Fills a map of scattered measurements, guided by the picture if there is one.
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

}  // namespace hexrelief::stages
