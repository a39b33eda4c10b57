// The surface stage on the device, lattice and disparity map in, the mesh cut along silhouettes out; and the
// stage's memory.
#pragma once

#include <cstddef>
#include <optional>

#include "cuda/common/arena.h"
#include "cuda/common/staging.h"
#include "cuda/common/surface_state.h"
#include "cuda/som/level.h"
#include "cuda/surface/fit/fit_disparities.h"
#include "cuda/surface/fit/fit_silhouettes.h"
#include "cuda/surface/pixels/pixel_surfaces.h"
#include "cuda/surface/topology/cut_vertices.h"
#include "cuda/surface/topology/label_triangles.h"
#include "cuda/surface/topology/snap_vertices.h"
#include "cuda/surface/topology/split_triangles.h"
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

// The state that the parts of the stage share, and the arrays that each has for itself.
struct SurfaceMemory {
    SurfaceState state;
    step::PixelArrays pixels;
    SnapArrays snap;
    SplitArrays split;
    LabelArrays labels;
    step::CutArrays cuts;
    FanArrays fans;
    SilhouetteFitArrays silhouettes;
    step::FitArrays fit;
};

// Takes the memory for a split lattice of about vertex_share times as many vertices as the lattice.
// map_on_device: null if the map is not on the device yet. Resets the arena. Throws Error(device) if
// memory is too small.
SurfaceMemory take_surface_memory(Arena& arena, const surface::DisparityMeshInput& input,
                                  const SurfaceConfig& config, const float* map_on_device,
                                  double vertex_share);

// Uploads the stage's input; the map only if it is not on the device yet.
void upload_input(cudaStream_t stream, Staging& staging, const surface::DisparityMeshInput& input,
                  bool with_map, const SurfaceMemory& memory);

// Waits for the stream and returns the mesh, or nothing if the capacity was too small for it.
std::optional<DisparityMesh> download_mesh(cudaStream_t stream, Staging& staging, const SurfaceState& state);

}  // namespace hexrelief::cuda
