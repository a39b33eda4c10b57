#include "pipeline/job/backend.h"

#include <sched.h>

#include <algorithm>
#include <fstream>
#include <map>
#include <memory>
#include <optional>
#include <thread>
#include <tuple>
#include <utility>

#include "pipeline/data/error.h"
#ifdef HEXRELIEF_HAS_CUDA
#include "cuda/cuda_matcher.h"
#include "cuda/cuda_mesher.h"
#endif

namespace hexrelief::job {
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
    return {"cpu",
            cpu_name(),
            [threads](const StereoPair& pair, const matching::MatchingConfig& config) {
                return matching::match_pair(pair, config, threads);
            },
            [threads](const DensityMap& density, const DisparityMap&, const MeshConfig& config,
                      const ProgressFunction& progress) {
                return mesher::solve_mesh(density, config, threads, progress);
            },
            [threads](const surface::DisparityMeshInput& input, const SurfaceConfig& config) {
                return surface::DisparityMeshResult{surface::cut_disparity_mesh(input, config, threads)};
            },
            [threads](const DensityMap& density, const BalanceConfig& config, balance::LatticePatch& patch) {
                balance::balance_patch(density, config, threads, patch);
            },
            {},
            {},
            {}};
}

#ifdef HEXRELIEF_HAS_CUDA
using cuda::copy_from_cuda_device;

struct CudaWorkers {
    cuda::CudaMesher mesher;
    std::unique_ptr<cuda::CudaMatcher> matcher;  // for those runs that match
};

Backend cuda_backend(int threads) {
    const auto made = std::make_shared<std::unique_ptr<CudaWorkers>>(std::make_unique<CudaWorkers>());
    return {"cuda",
            (*made)->mesher.device().name,
            [made](const StereoPair& pair, const matching::MatchingConfig& config) {
                std::unique_ptr<cuda::CudaMatcher>& matcher = (*made)->matcher;
                if (!matcher) matcher = std::make_unique<cuda::CudaMatcher>();
                return matcher->match_pair(pair, config);
            },
            [made](const DensityMap& density, const DisparityMap& map, const MeshConfig& config,
                   const ProgressFunction& progress) {
                return (*made)->mesher.solve(density, config, progress, &map);
            },
            [made, threads](const surface::DisparityMeshInput& input, const SurfaceConfig& config) {
                cuda::CudaMesher& mesher = (*made)->mesher;
                return mesher.can_cut_meshes() ? mesher.cut_disparity_mesh(input, config)
                                               : surface::DisparityMeshResult{
                                                     surface::cut_disparity_mesh(input, config, threads)};
            },
            [made](const DensityMap& density, const BalanceConfig& config, balance::LatticePatch& patch) {
                (*made)->mesher.balance_patch(density, config, patch);
            },
            [made] {
                made->reset();
                cuda::end_cuda();
            },
            {},
            {}};
}

// nullopt where auto should take the CPU: no device, or one that does not start, which `why` is told.
std::optional<Backend> usable_cuda_backend(int threads, std::string& why) {
    try {
        if (!cuda::list_cuda_devices(nullptr).empty()) return cuda_backend(threads);
    } catch (const Error& error) {
        why = error.what();
    }
    return std::nullopt;
}

void append_cuda_devices(std::vector<DeviceDescription>& devices) {
    std::string why;
    for (const cuda::CudaDevice& device : cuda::list_cuda_devices(&why))
        devices.push_back({"cuda", device.name,
                           "compute capability " + device.compute_capability + ", " +
                               std::to_string(device.memory_bytes >> 20) + " MiB, " +
                               std::to_string(device.multiprocessors) + " multiprocessors",
                           true});
    if (!why.empty()) devices.push_back({"cuda", "none", why, false});
}
#else
Backend cuda_backend(int) {
    throw Error(
        ErrorKind::device,
        "backend cuda: this program was built without CUDA; use --backend cpu, or build the preset 'cuda'");
}

std::optional<Backend> usable_cuda_backend(int, std::string&) {
    return std::nullopt;
}

void append_cuda_devices(std::vector<DeviceDescription>&) {}

void copy_from_cuda_device(void*, const void*, std::size_t) {
    throw Error(ErrorKind::device,
                "an array in a device's memory: this build is without CUDA; copy it to the host first");
}
#endif

Backend pick_any(config::BackendChoice choice, int threads, MeshMethod method) {
    if (choice == config::BackendChoice::cuda) return cuda_backend(threads);
    std::string why;
    if (choice == config::BackendChoice::automatic && method == MeshMethod::cellular)
        if (auto backend = usable_cuda_backend(threads, why)) return std::move(*backend);
    Backend cpu = cpu_backend(threads);
    cpu.missed = why;
    return cpu;
}

}  // namespace

int effective_threads(int configured) {
    constexpr int kHarmless = 8;
    cpu_set_t allowed;
    int usable = static_cast<int>(std::thread::hardware_concurrency());
    if (sched_getaffinity(0, sizeof allowed, &allowed) == 0) usable = CPU_COUNT(&allowed);
    return configured > 0 ? std::min(configured, std::max(usable, kHarmless)) : std::max(1, usable);
}

Backend pick_backend(config::BackendChoice choice, int threads, MeshMethod method) {
    Backend backend = pick_any(choice, threads, method);
    backend.give_back = {};
    return backend;
}

BackendPicker pick_for_one_run() {
    setenv("CUDA_DEVICE_MAX_CONNECTIONS", "1", 0);
    return pick_any;
}

BackendPicker keep_backends() {
    using Key = std::tuple<config::BackendChoice, int, MeshMethod>;
    return [kept = std::make_shared<std::map<Key, Backend>>()](config::BackendChoice choice, int threads,
                                                               MeshMethod method) {
        const Key key{choice, threads, method};
        const auto known = kept->find(key);
        if (known != kept->end()) return known->second;
        return kept->emplace(key, pick_backend(choice, threads, method)).first->second;
    };
}

namespace {

// Calls the first function, and the second where the device fails or has failed before.
template <typename Result, typename... Arguments>
std::function<Result(Arguments...)> either(std::function<Result(Arguments...)> device,
                                           std::function<Result(Arguments...)> cpu,
                                           std::function<void(const Error&)> replace,
                                           std::shared_ptr<const bool> is_replaced) {
    return [=](Arguments... arguments) {
        if (*is_replaced) return cpu(arguments...);
        try {
            return device(arguments...);
        } catch (const Error& error) {
            if (error.kind() != ErrorKind::device) throw;
            replace(error);
        }
        return cpu(arguments...);
    };
}

}  // namespace

std::string going_on_without(const std::string& failure) {
    return failure + "; the CPU goes on";
}

Backend with_replacement(Backend device, Backend cpu, std::function<void(const std::string&)> warn) {
    const auto is_replaced = std::make_shared<bool>(false);
    const std::function<void(const Error&)> replace = [is_replaced,
                                                       warn = std::move(warn)](const Error& error) {
        *is_replaced = true;
        warn(going_on_without(error.what()));
    };
    Backend both = device;
    both.match_pair = either(device.match_pair, cpu.match_pair, replace, is_replaced);
    both.solve_mesh = either(device.solve_mesh, cpu.solve_mesh, replace, is_replaced);
    both.cut_disparity_mesh = either(device.cut_disparity_mesh, cpu.cut_disparity_mesh, replace, is_replaced);
    both.balance_patch = either(device.balance_patch, cpu.balance_patch, replace, is_replaced);
    both.is_replaced = is_replaced;
    return both;
}

std::vector<DeviceDescription> list_devices() {
    const int threads = effective_threads(0);
    std::vector<DeviceDescription> devices = {
        {"cpu", cpu_name(), std::to_string(threads) + (threads == 1 ? " thread" : " threads"), true}};
    append_cuda_devices(devices);
    return devices;
}

void copy_from_device(void* target, const void* source, std::size_t bytes) {
    copy_from_cuda_device(target, source, bytes);
}

}  // namespace hexrelief::job
