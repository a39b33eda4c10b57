// Small patches of matches taken out.
#pragma once

#include "cuda/matching/common/device_raster.h"
#include "pipeline/matching/refine/consistency.h"

namespace hexrelief::cuda {

// labels, sizes: an entry a pixel, of any content. map: with a border of kUnknown16.
struct SpeckleArrays {
    std::uint32_t *labels, *sizes;
};
void remove_speckles(cudaStream_t stream, const ConsistencyConfig& config, const SpeckleArrays& arrays,
                     const DisparityOut& map);

}  // namespace hexrelief::cuda
