// The mesh on the device: lattice and disparity map in, the mesh cut along silhouettes out.
#pragma once

#include "cuda/common/staging.h"
#include "cuda/som/level.h"
#include "mesher/surface/cut_disparity_mesh.h"

namespace hexrelief::cuda {

// Whether a block gets as much shared memory as the kernel takes: from compute capability 8.0 on.
bool can_cut_meshes();

// The same bytes as surface::cut_disparity_mesh(). Resets the arena. Throws Error(device) where memory is
// too small.
surface::DisparityMeshResult cut_disparity_mesh(const Launch& launch, Arena& arena, Staging& staging,
                                                const float* map_on_device,
                                                const surface::DisparityMeshInput& input,
                                                const SurfaceConfig& config);

}  // namespace hexrelief::cuda
