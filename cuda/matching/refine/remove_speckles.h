// Removes small connected components of matches.
#pragma once

#include "cuda/matching/common/device_raster.h"
#include "pipeline/matching/refine/consistency.h"

namespace hexrelief::cuda {

// Those of step::Patches: uninitialised, an entry per pixel.
struct SpeckleArrays {
    std::uint32_t *parents, *sizes;
};
// Removes speckles from a map with a border of kUnknown16.
void remove_speckles(cudaStream_t stream, const matching::ConsistencyConfig& config,
                     const SpeckleArrays& arrays, const matching::DisparityOut& map);

}  // namespace hexrelief::cuda
