// The one place that picks what matches pairs, solves the 2D mesh and cuts it along depth discontinuities.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "mesher/mesher.h"
#include "pipeline/config/config.h"
#include "pipeline/stages/disparity.h"

namespace hexrelief {

struct Backend {
    std::string name;    // "cpu" or "cuda"
    std::string device;  // its make and model
    PairMatcher match_pair;
    std::function<MeshResult(const DensityMap&, const DisparityMap&, const MeshConfig&,
                             const ProgressFunction&)>
        solve_mesh;
    std::function<DisparityMeshResult(const DisparityMeshInput&, const SurfaceConfig&)> cut_disparity_mesh;
};

struct DeviceDescription {
    std::string backend;
    std::string name;
    std::string details;  // threads, memory, ...
    bool usable = true;
};

// The threads that `configured` stands for: itself, or for 0 all that the process may use; at least 1.
int effective_threads(int configured);

// auto takes CUDA where it is built in, has a usable device and can do the method. Throws Error(device) where
// the choice is not built in or has no usable device.
Backend pick_backend(BackendChoice choice, int threads, MeshMethod method = MeshMethod::cellular);

// The CPU first.
std::vector<DeviceDescription> list_devices();

}  // namespace hexrelief
