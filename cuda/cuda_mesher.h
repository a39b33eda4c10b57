// The CUDA backend of the mesh and of the mesh laid over it: the same bytes as solve_mesh and
// cut_disparity_mesh.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "mesher/mesher.h"
#include "mesher/surface/disparity_mesh.h"

namespace hexrelief {

struct CudaDevice {
    int index = 0;
    std::string name;
    std::string compute_capability;  // "9.0"
    std::size_t memory_bytes = 0;
    int multiprocessors = 0;
};

// All CUDA devices; empty, with the reason in *why where given, when there is no driver, a too old one, or no
// device.
std::vector<CudaDevice> list_cuda_devices(std::string* why);

// A context on the first device with its stream and memory, kept from mesh to mesh. Not safe for use by two
// threads at once.
class CudaMesher {
  public:
    // Throws Error(device): no driver, a driver older than the toolkit, no device, a device whose
    // architecture is not built in.
    CudaMesher();
    ~CudaMesher();
    const CudaDevice& device() const;

    // As solve_mesh. Throws Error(device) where memory is too small or an image side exceeds 32,767 px,
    // Error(usage) for the sequential method, which has no parallel form. A map is copied to the device
    // meanwhile and stays there, under MeshResult::map_on_device, until the next one; may be null.
    MeshResult solve(const DensityMap& density, const MeshConfig& config, const ProgressFunction& progress,
                     const DisparityMap* map = nullptr);

    // Whether the device can: from compute capability 8.0 on.
    bool can_cut_meshes() const;
    // As hexrelief::cut_disparity_mesh. Throws Error(input) as it does, Error(device) where memory is too
    // small.
    DisparityMeshResult cut_disparity_mesh(const DisparityMeshInput& input, const SurfaceConfig& config);

  private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace hexrelief
