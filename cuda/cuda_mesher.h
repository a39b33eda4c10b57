// The CUDA backend's manual for meshes; cuda_matcher.h is the one for pairs. CudaMesher offers solve_mesh,
// cut_disparity_mesh (mesher/mesher.h) and balance_patch (mesher/balance/balance.h) on an NVIDIA GPU, with
// the same parameters, units, errors and, to the byte, the same results.
//
// It needs compute capability 7.5 and a driver for the toolkit that it was built with. It compiles and links
// without a device; then list_cuda_devices() is empty. All errors of the device are Error(device) with one
// line that says what failed and what to do; the object may be used again after an error.
#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <vector>

#include "mesher/balance/balance.h"
#include "mesher/common/device_figures.h"
#include "mesher/mesher.h"

namespace hexrelief::cuda {

struct CudaDevice {
    int index = 0;
    std::string name;
    std::string compute_capability;  // "9.0"
    std::size_t memory_bytes = 0;
    int multiprocessors = 0;
};

// Returns all CUDA devices. The list is empty if there is no driver, the driver is too old, or there is no
// device; *why, unless why is null, then says which.
std::vector<CudaDevice> list_cuda_devices(std::string* why);

// Copies `bytes` bytes from the device to the host, after all pending work on the
// current device. Throws Error(device).
void copy_from_cuda_device(void* target, const void* source, std::size_t bytes);

// Releases the current device and the driver, for a process that uses neither again; all objects of
// this folder must be gone. The system would do so at the end of the process, which then takes 0.05 s
// longer. Errors are ignored.
void end_cuda();

// A context on the first device, with a stream and memory that is kept from call to call. Any thread may call
// it, but only one at a time.
class CudaMesher {
  public:
    // Throws Error(device) if there is no driver, a driver older than the toolkit, no device, or a device for
    // whose architecture this program has no code.
    CudaMesher();
    ~CudaMesher();
    const CudaDevice& device() const;

    // Announces the map that the next mesh is cut by: solve() copies it to the device while it trains, so
    // that cut_disparity_mesh() need not. The map must stay unchanged, at the same address, until the
    // next call of solve().
    void expect_map(const DisparityMap& map);

    // Runs mesher::solve_mesh on the device. Also throws Error(usage) for MeshMethod::sequential and for more
    // than 100 sweeps of balancing, and Error(device) if memory is too small, an image side exceeds 32,767
    // px, or a neighbourhood radius exceeds 27.
    HexMesh2D solve(const DensityMap& density, const MeshConfig& config, const ProgressFunction& progress);

    // Runs balance::balance_patch on the device. Throws Error(usage) for more than 100 sweeps and
    // Error(device) if memory is too small; the patch is then unchanged.
    void balance_patch(const DensityMap& density, const BalanceConfig& config, balance::LatticePatch& patch);

    // True if the device supports cut_disparity_mesh, which needs compute capability 8.0.
    bool can_cut_meshes() const;
    // Runs surface::cut_disparity_mesh on the device. Also throws Error(device) if memory is too small.
    DisparityMesh cut_disparity_mesh(const surface::DisparityMeshInput& input, const SurfaceConfig& config);

    // Returns the figures of the latest solve() and cut_disparity_mesh().
    const DeviceFigures& figures() const;

  private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace hexrelief::cuda
