// The CUDA backend's manual for meshes; cuda_matcher.h is that for pairs. CudaMesher offers solve_mesh,
// cut_disparity_mesh (mesher/mesher.h) and balance_patch (mesher/balance/balance.h) on an NVIDIA GPU, with
// the same parameters, units, errors and, to the byte, the same results.
//
// Needs compute capability 7.5 and a driver for the toolkit that it was built with. Compiles and links
// without a device; then list_cuda_devices() is empty. All errors of the device are Error(device) with one
// line that says what failed and what to do; the object may be used again after an error.
#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <vector>

#include "mesher/balance/balance.h"
#include "mesher/mesher.h"

namespace hexrelief {

struct CudaDevice {
    int index = 0;
    std::string name;
    std::string compute_capability;  // "9.0"
    std::size_t memory_bytes = 0;
    int multiprocessors = 0;
};

// All CUDA devices. Empty where there is no driver, one that is too old, or no device; *why, where why is not
// null, then says which.
std::vector<CudaDevice> list_cuda_devices(std::string* why);

// Bytes of a device's memory, here, when all work at hand on the current device is done. Throws
// Error(device).
void copy_from_cuda_device(void* target, const void* source, std::size_t bytes);

// Lets go of the current device and of the driver, for a process that uses neither again; all objects of this
// folder must be gone. The system would do it when the process ends, which then takes 0.05 s longer. Errors
// are of no interest any more.
void end_cuda();

// A context on the first device with a stream and memory that is kept from call to call. Any thread may call,
// but only one at a time.
class CudaMesher {
  public:
    // Throws Error(device): no driver, a driver older than the toolkit, no device, or a device whose
    // architecture this program has no code for.
    CudaMesher();
    ~CudaMesher();
    const CudaDevice& device() const;

    // solve_mesh on the device. `map`, where it is not null, is copied to the device while the mesh is
    // trained and stays there until the next call with a map: cut_disparity_mesh need not copy it again where
    // its input names MeshResult::map_on_device. Throws also Error(usage) for MeshMethod::sequential and for
    // more than 100 sweeps of balancing; Error(device) where memory is too small, an image side exceeds
    // 32,767 px, or a neighbourhood radius exceeds 27.
    MeshResult solve(const DensityMap& density, const MeshConfig& config, const ProgressFunction& progress,
                     const DisparityMap* map = nullptr);

    // hexrelief::balance_patch on the device. Throws Error(usage) for more than 100 sweeps, Error(device)
    // where memory is too small; the patch is then as it was.
    void balance_patch(const DensityMap& density, const BalanceConfig& config, LatticePatch& patch);

    // Whether the device has cut_disparity_mesh: from compute capability 8.0 on.
    bool can_cut_meshes() const;
    // hexrelief::cut_disparity_mesh on the device. Throws also Error(device) where memory is too small.
    DisparityMeshResult cut_disparity_mesh(const DisparityMeshInput& input, const SurfaceConfig& config);

  private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace hexrelief
