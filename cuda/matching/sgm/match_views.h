// Semi-global matching on the device: both views' winners.
#pragma once

#include "cuda/matching/common/stage_clock.h"
#include "cuda/matching/sgm/pictures.h"
#include "cuda/matching/sgm/volume.h"

namespace hexrelief::cuda {

// Sets both views, in 1/16 px above range.min_px, in bands. half: see
// find_windows(). What it takes of the arena is free again. range.count: 1..kMostDisparities.
inline constexpr int kMostDisparities = 2048;
void match_views(cudaStream_t stream, Arena& arena, const PairArrays& pair, const DisparityRange& range,
                 int p1, const RasterView<std::int16_t>& half, const RasterView<std::int16_t>& left,
                 const RasterView<std::int16_t>& right, StageClock& clock);

}  // namespace hexrelief::cuda
