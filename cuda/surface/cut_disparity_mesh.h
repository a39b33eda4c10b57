// The surface stage on the device: lattice and disparity map in, the mesh cut along silhouettes out.
#pragma once

#include "cuda/common/staging.h"
#include "cuda/som/level.h"
#include "mesher/surface/cut_disparity_mesh.h"

namespace hexrelief::cuda {

// True if a block gets as much shared memory as the kernels need, which takes compute capability 8.0.
bool can_cut_meshes();

// Returns the same bytes as surface::cut_disparity_mesh(). map_on_device: the map's copy on the device, or
// null if it still has to be uploaded. `device_s` gets the seconds by the device's clock, without transfers.
// Resets the arena. Throws Error(device) if memory is too small.
DisparityMesh cut_disparity_mesh(const Launch& launch, Arena& arena, Staging& staging,
                                 const float* map_on_device, const surface::DisparityMeshInput& input,
                                 const SurfaceConfig& config, double& device_s);

}  // namespace hexrelief::cuda
