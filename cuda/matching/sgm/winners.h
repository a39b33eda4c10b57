// Finds the best disparity of each pixel, in both views.
#pragma once

#include "cuda/matching/sgm/volume.h"

namespace hexrelief::cuda {

// Sets the kept rows of both views, in 1/16 px above the range's first disparity, from the sums of both axes.
void find_winners(cudaStream_t stream, const DeviceVolume& volume,
                  const matching::RasterView<std::int16_t>& left,
                  const matching::RasterView<std::int16_t>& right);

}  // namespace hexrelief::cuda
