// A dense map from scattered measurements, guided by the picture where there is one.
#pragma once

#include "pipeline/data/disparity_map.h"

namespace hexrelief::densify {

// sparse: see Sparsity::is_sparse(). left: the picture that the map belongs to, of its size, or empty.
// Pixels that measurements surround get the disparity of one of the surfaces around them; others stay
// unknown. Known pixels keep their disparities. origins: matched where it was known, filled where it was not.
// The same bytes for any number of threads (>= 1).
DisparityMap densify(const DisparityMap& sparse, const Image& left, int threads);

}  // namespace hexrelief::densify
