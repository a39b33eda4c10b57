#include "pipeline/bench/backends.h"

namespace hexrelief::bench {

std::vector<job::BackendPointer> usable_backends(int threads) {
    std::vector<job::BackendPointer> backends{job::pick_backend(config::BackendChoice::cpu, threads)};
    for (const job::DeviceDescription& device : job::list_devices())
        if (device.backend == "cuda" && device.usable) {
            backends.push_back(job::pick_backend(config::BackendChoice::cuda, threads));
            break;
        }
    return backends;
}

}  // namespace hexrelief::bench
