// A part of a lattice, some of whose vertices stay, balanced on the device.
#pragma once

#include "cuda/common/arena.h"
#include "cuda/common/launch.h"
#include "cuda/common/staging.h"
#include "mesher/balance/balance.h"

namespace hexrelief::cuda {

// balance::balance_patch. Takes its memory from the arena, which is reset; leaves the patch as it was where
// the device fails. Throws Error(device), also where memory is too small; Error(usage) for more than
// kMostSweeps sweeps.
void balance_patch(const Launch& launch, Arena& arena, Staging& staging, const DensityMap& density,
                   const BalanceConfig& config, balance::LatticePatch& patch);

}  // namespace hexrelief::cuda
