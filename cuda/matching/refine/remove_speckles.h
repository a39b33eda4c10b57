// Small patches of matches taken out.
#pragma once

#include "cuda/matching/common/device_raster.h"
#include "pipeline/matching/refine/consistency.h"

namespace hexrelief::cuda {

// labels, sizes: an entry a pixel, of any content. map: with a border of kUnknown16.
struct SpeckleArrays {
    std::uint32_t *labels, *sizes;
};
void remove_speckles(cudaStream_t stream, const matching::ConsistencyConfig& config,
                     const SpeckleArrays& arrays, const matching::DisparityOut& map);

}  // namespace hexrelief::cuda
