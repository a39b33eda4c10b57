// Sub-pixel refinement of a pixel's best disparity.
#pragma once

#include "pipeline/base/host_device.h"
#include "pipeline/matching/common/bordered_raster.h"
#include "pipeline/matching/sgm/path_step.h"

namespace hexrelief::step {

// Returns a disparity in 1/16 px. lower, middle, upper: the costs at disparity - 1, disparity
// and disparity + 1.
HEXRELIEF_HD int refined_winner(int disparity, int lower, int middle, int upper) {
    return matching::kOnePixel * disparity + parabola_vertex(lower, middle, upper);
}

}  // namespace hexrelief::step
