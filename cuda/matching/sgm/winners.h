// The best disparity of each pixel, in both views.
#pragma once

#include "cuda/matching/sgm/volume.h"

namespace hexrelief::cuda {

// Of a pixel of the right view: step::winner_key, and below it the winner in 1/16 px, in 16 bits.
using RightBest = unsigned long long;

// Sets the kept rows of both views, in 1/16 px above the range's first, from the sums of both axes.
// right_best: width * kept.count() entries of scratch memory.
void find_winners(cudaStream_t stream, const DeviceVolume& volume, RightBest* right_best,
                  const RasterView<std::int16_t>& left, const RasterView<std::int16_t>& right);

}  // namespace hexrelief::cuda
