// Semi-global matching on the device: both views' winners.
#pragma once

#include <cstddef>

#include "cuda/matching/common/stage_clock.h"
#include "cuda/matching/sgm/pictures.h"
#include "cuda/matching/sgm/volume.h"
#include "cuda/matching/sgm/winners.h"
#include "pipeline/matching/sgm/volume.h"

namespace hexrelief::cuda {

struct MatchingArrays {
    PairArrays pair;
    DeviceVolume volume;  // of the largest band
    WinnerKeys keys;
};

// count: 1..kMostDisparities.
MatchingArrays take_matching_arrays(cudaStream_t stream, Arena& arena, int width, int height, int channels,
                                    int count);

// Sets both views, in 1/16 px above range.min_px, in the bands of hexrelief::match_views().
void match_views(cudaStream_t stream, const MatchingArrays& arrays, int min_px, int p1,
                 const RasterView<std::int16_t>& left, const RasterView<std::int16_t>& right,
                 StageClock& clock);

}  // namespace hexrelief::cuda
