// The sheet on the device: lattice and disparity map in, the mesh cut along silhouettes out.
#pragma once

#include "cuda/som/level.h"
#include "cuda/common/staging.h"
#include "mesher/surface/disparity_mesh.h"

namespace hexrelief::cuda {

// Whether a block gets as much shared memory as the kernel takes: from compute capability 8.0 on.
bool can_open_sheets();

// The same bytes as hexrelief::open_sheet(). Resets the arena. Throws Error(device) where memory is too
// small.
SheetResult open_sheet(const Launch& launch, Arena& arena, Staging& staging, const float* map_on_device,
                       const SheetInput& input, const SheetConfig& config);

}  // namespace hexrelief::cuda
