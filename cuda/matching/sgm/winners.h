// The best disparity of each pixel, in both views.
#pragma once

#include "cuda/matching/sgm/volume.h"

namespace hexrelief::cuda {

// What has no match: a key from here on.
inline constexpr std::uint32_t kNoMatchKey = 0xffffu << 16;

// Sets the sums and the kept rows of both views, in 1/16 px above min_px, from the sums of both axes.
// right_keys: step::winner_key of the right view's pixels, width * kept.count() entries of scratch memory.
void find_winners(cudaStream_t stream, const DeviceVolume& volume, std::uint32_t* right_keys, int min_px,
                  const RasterView<std::int16_t>& left, const RasterView<std::int16_t>& right);

}  // namespace hexrelief::cuda
