#include "pipeline/app/backend.h"

#include <sched.h>

#include <algorithm>
#include <fstream>
#include <thread>

#include "pipeline/data/error.h"

namespace hexrelief {
namespace {

std::string cpu_name() {
    std::ifstream info("/proc/cpuinfo");
    for (std::string line; std::getline(info, line);) {
        if (!line.starts_with("model name")) continue;
        const std::size_t from = line.find_first_not_of(" \t", line.find(':') + 1);
        if (from != std::string::npos) return line.substr(from);
    }
    return "CPU";
}

Backend cpu_backend(int threads) {
    return {"cpu", cpu_name(),
            [threads](const DensityMap& density, const DisparityMap& map, const MeshConfig& config,
                      const ProgressFunction& progress) { return solve_mesh_cpu(density, map, config, threads, progress); }};
}

}  // namespace

int effective_threads(int configured) {
    if (configured > 0) return configured;
    cpu_set_t allowed;
    if (sched_getaffinity(0, sizeof allowed, &allowed) == 0) return std::max(1, CPU_COUNT(&allowed));
    return std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
}

Backend pick_backend(BackendChoice choice, int threads) {
    if (choice == BackendChoice::cuda)
        throw Error(ErrorKind::device, "backend cuda: this program was built without CUDA; use --backend cpu, or build the preset 'cuda'");
    return cpu_backend(threads);
}

std::vector<DeviceDescription> list_devices() {
    const int threads = effective_threads(0);
    return {{"cpu", cpu_name(), std::to_string(threads) + (threads == 1 ? " thread" : " threads"), true}};
}

}  // namespace hexrelief
