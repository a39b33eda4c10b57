// Computes the matching costs of a band of rows.
#pragma once

#include "cuda/matching/sgm/pictures.h"
#include "cuda/matching/sgm/volume.h"

namespace hexrelief::cuda {

// Sets the volume's costs, and clears its right_best.
void find_costs(cudaStream_t stream, const PairArrays& pair, const DeviceVolume& volume);

}  // namespace hexrelief::cuda
