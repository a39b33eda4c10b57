// The best disparity of each pixel, in both views.
#pragma once

#include "pipeline/base/thread_pool.h"
#include "pipeline/matching/common/bordered_raster.h"
#include "pipeline/matching/sgm/paths.h"
#include "pipeline/matching/sgm/volume.h"

namespace hexrelief::matching {

// Sets rows first .. end - 1 of both views from the volume, which must contain them. The right view's
// costs are the left view's at the matching pixels: left(x, d) = right(x - d, d). A right pixel that no
// window matches is unknown.
void find_winners(const MatchingInput& input, const MatchingVolume& volume, int first, int end,
                  ViewDisparities& views, ThreadPool& pool);

}  // namespace hexrelief::matching
