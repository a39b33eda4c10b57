// Device memory of the surface stage.
#pragma once

#include <cstddef>
#include <optional>

#include "cuda/common/arena.h"
#include "cuda/common/staging.h"
#include "cuda/common/surface_state.h"
#include "cuda/surface/fit/fit_disparities.h"
#include "cuda/surface/fit/fit_silhouettes.h"
#include "cuda/surface/pixels/discontinuities.h"
#include "cuda/surface/topology/cut_vertices.h"
#include "cuda/surface/topology/join_cuts.h"
#include "cuda/surface/topology/label_triangles.h"
#include "cuda/surface/topology/snap_vertices.h"
#include "cuda/surface/topology/split_triangles.h"
#include "mesher/surface/cut_disparity_mesh.h"

namespace hexrelief::cuda {

// What the parts share, and what each has for itself.
struct SurfaceMemory {
    SurfaceState state;
    PixelArrays pixels;
    SnapArrays snap;
    SplitArrays split;
    LabelArrays labels;
    CutArrays cuts;
    FanArrays fans;
    SilhouetteFitArrays silhouettes;
    FitArrays fit;
};

// For a split lattice of vertex_share times as many vertices as the lattice, and some. map_on_device: null =
// there is none yet. Resets the arena. Throws Error(device) where memory is too small.
SurfaceMemory take_surface_memory(Arena& arena, const surface::DisparityMeshInput& input,
                                  const SurfaceConfig& config, const float* map_on_device,
                                  double vertex_share);

// What the stage reads; the map where it is not there yet.
void upload_input(cudaStream_t stream, Staging& staging, const surface::DisparityMeshInput& input,
                  bool with_map, const SurfaceMemory& memory);

// The mesh, once the stream has come there; nothing: there was too little memory for it.
std::optional<DisparityMesh> download_mesh(cudaStream_t stream, Staging& staging, const SurfaceState& state);

}  // namespace hexrelief::cuda
