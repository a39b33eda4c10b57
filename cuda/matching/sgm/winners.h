// The best disparity of each pixel, in both views.
#pragma once

#include "cuda/matching/sgm/volume.h"

namespace hexrelief::cuda {

// step::winner_key of the kept rows' pixels, width * kept.count() entries each. What has no match: a key from
// kNoMatchKey on.
struct WinnerKeys {
    std::uint32_t *left, *right;
};
inline constexpr std::uint32_t kNoMatchKey = 0xffffu << 16;

// Sets the kept rows of both views, in 1/16 px above min_px.
void find_winners(cudaStream_t stream, const DeviceVolume& volume, const WinnerKeys& keys, int min_px,
                  const RasterView<std::int16_t>& left, const RasterView<std::int16_t>& right);

}  // namespace hexrelief::cuda
