#include "pipeline/bench/backends.h"

namespace hexrelief {

std::vector<BackendPointer> usable_backends(int threads) {
    std::vector<BackendPointer> backends{pick_backend(BackendChoice::cpu, threads)};
    for (const DeviceDescription& device : list_devices())
        if (device.backend == "cuda" && device.usable) {
            backends.push_back(pick_backend(BackendChoice::cuda, threads));
            break;
        }
    return backends;
}

}  // namespace hexrelief
