#include "pipeline/bench/backends.h"

namespace hexrelief {

std::vector<Backend> usable_backends(int threads) {
    std::vector<Backend> backends{pick_backend(config::BackendChoice::cpu, threads)};
    for (const DeviceDescription& device : list_devices())
        if (device.backend == "cuda" && device.usable) {
            backends.push_back(pick_backend(config::BackendChoice::cuda, threads));
            break;
        }
    return backends;
}

}  // namespace hexrelief
