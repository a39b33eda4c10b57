// Balances a part of a lattice, some of whose vertices are held, on the device.
#pragma once

#include "cuda/common/arena.h"
#include "cuda/common/launch.h"
#include "cuda/common/staging.h"
#include "mesher/balance/balance.h"

namespace hexrelief::cuda {

// Runs balance::balance_patch. Resets the arena and takes its memory from it; leaves the patch
// unchanged if the device fails. Throws Error(device), also if memory is too small, and Error(usage) for
// more than kMostSweeps sweeps.
void balance_patch(const Launch& launch, Arena& arena, Staging& staging, const DensityMap& density,
                   const BalanceConfig& config, balance::LatticePatch& patch);

}  // namespace hexrelief::cuda
