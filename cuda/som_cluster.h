// Training of small levels by one thread-block cluster, with the whole map in its distributed shared memory.
#pragma once

#include <cstddef>

#include "cuda/level.h"

namespace hexrelief::cuda {

// Blocks of the largest cluster that the device can hold, 0 where it has none (before Hopper).
int training_cluster_blocks();

// Whether the level's map fits the cluster's shared memory.
bool fits_cluster(const Launch& launch, const LevelView& level);

// As train() in som.h. Precondition: fits_cluster.
void train_in_cluster(const Launch& launch, const LevelView& level, int first, int count, int crr);

}  // namespace hexrelief::cuda
