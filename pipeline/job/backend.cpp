#include "pipeline/job/backend.h"

#include <sched.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <thread>
#include <utility>

#include "pipeline/data/error.h"
#include "pipeline/job/budget/budget.h"
#ifdef HEXRELIEF_HAS_CUDA
#include "cuda/cuda_matcher.h"
#include "cuda/cuda_mesher.h"
#endif

namespace hexrelief::job {
namespace {

// Seconds on one thread.
constexpr double kPixelAndDisparity_s = 7e-9, kPixel_s = 85e-9, kVertex_s = 4.5e-6;
constexpr double kSerialShare = 0.1;
constexpr double kWidthPerDisparity = 7;
constexpr double kBudgetSolves = 7;

// Time from the first call of the CUDA runtime to the first kernel, on an H200. The device's time for the
// work itself is less than the estimate's error.
constexpr double kDeviceStart_s = 0.2;

std::string cpu_name() {
    std::ifstream info("/proc/cpuinfo");
    for (std::string line; std::getline(info, line);) {
        if (!line.starts_with("model name")) continue;
        const std::size_t from = line.find_first_not_of(" \t", line.find(':') + 1);
        if (from != std::string::npos) return line.substr(from);
    }
    return "CPU";
}

class CpuBackend final : public Backend {
  public:
    using Backend::Backend;
    std::string name() const override { return "cpu"; }
    std::string device() const override { return cpu_name(); }
    matching::MatchedMap match_pair(const StereoPair& pair, const matching::MatchingConfig& config) override {
        return matching::match_pair(pair, config, threads());
    }
    HexMesh2D solve_mesh(const DensityMap& density, const MeshConfig& config,
                         const ProgressFunction& progress) override {
        return mesher::solve_mesh(density, config, threads(), progress);
    }
    DisparityMesh cut_disparity_mesh(const surface::DisparityMeshInput& input,
                                     const SurfaceConfig& config) override {
        return surface::cut_disparity_mesh(input, config, threads());
    }
    void balance_patch(const DensityMap& density, const BalanceConfig& config,
                       balance::LatticePatch& patch) override {
        balance::balance_patch(density, config, threads(), patch);
    }
};

#ifdef HEXRELIEF_HAS_CUDA
class CudaBackend final : public Backend {
  public:
    explicit CudaBackend(int threads) : Backend(threads), device_(mesher_->device().name) {}
    std::string name() const override { return "cuda"; }
    std::string device() const override { return device_; }
    matching::MatchedMap match_pair(const StereoPair& pair, const matching::MatchingConfig& config) override {
        if (!matcher_) matcher_ = std::make_unique<cuda::CudaMatcher>();
        return matcher_->match_pair(pair, config);
    }
    void expect_map(const DisparityMap& map) override { mesher_->expect_map(map); }
    HexMesh2D solve_mesh(const DensityMap& density, const MeshConfig& config,
                         const ProgressFunction& progress) override {
        return mesher_->solve(density, config, progress);
    }
    DisparityMesh cut_disparity_mesh(const surface::DisparityMeshInput& input,
                                     const SurfaceConfig& config) override {
        if (mesher_->can_cut_meshes()) return mesher_->cut_disparity_mesh(input, config);
        return surface::cut_disparity_mesh(input, config, threads());
    }
    void balance_patch(const DensityMap& density, const BalanceConfig& config,
                       balance::LatticePatch& patch) override {
        mesher_->balance_patch(density, config, patch);
    }
    DeviceFigures figures() const override { return mesher_->figures(); }
    void give_back() override {
        matcher_.reset();
        mesher_.reset();
        cuda::end_cuda();
    }

  private:
    std::unique_ptr<cuda::CudaMesher> mesher_ = std::make_unique<cuda::CudaMesher>();
    std::unique_ptr<cuda::CudaMatcher> matcher_;  // null until a run matches
    std::string device_;
};

BackendPointer cuda_backend(int threads) {
    return std::make_shared<CudaBackend>(threads);
}

// Returns null if there is no device, or if the device does not start; then `why` gets the reason.
BackendPointer usable_cuda_backend(int threads, std::string& why) {
    try {
        if (!cuda::list_cuda_devices(nullptr).empty()) return cuda_backend(threads);
    } catch (const Error& error) {
        why = error.what();
    }
    return nullptr;
}

using cuda::copy_from_cuda_device;

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
BackendPointer cuda_backend(int) {
    throw Error(
        ErrorKind::device,
        "backend cuda: this program was built without CUDA; use --backend cpu, or build the preset 'cuda'");
}

BackendPointer usable_cuda_backend(int, std::string&) {
    return nullptr;
}

void append_cuda_devices(std::vector<DeviceDescription>&) {}

void copy_from_cuda_device(void*, const void*, std::size_t) {
    throw Error(ErrorKind::device,
                "an array in a device's memory: this build is without CUDA; copy it to the host first");
}
#endif

}  // namespace

int effective_threads(int configured) {
    constexpr int kHarmless = 8;
    cpu_set_t allowed;
    int usable = static_cast<int>(std::thread::hardware_concurrency());
    if (sched_getaffinity(0, sizeof allowed, &allowed) == 0) usable = CPU_COUNT(&allowed);
    return configured > 0 ? std::min(configured, std::max(usable, kHarmless)) : std::max(1, usable);
}

BackendPointer pick_backend(config::BackendChoice choice, int threads, MeshMethod method) {
    if (choice == config::BackendChoice::cuda) return cuda_backend(threads);
    std::string why;
    if (choice == config::BackendChoice::automatic && method == MeshMethod::cellular)
        if (BackendPointer backend = usable_cuda_backend(threads, why)) return backend;
    const auto cpu = std::make_shared<CpuBackend>(threads);
    cpu->missed = why;
    return cpu;
}

Backends Backends::for_one_run() {
    setenv("CUDA_DEVICE_MAX_CONNECTIONS", "1", 0);
    Backends backends;
    backends.ends_with_run_ = true;
    return backends;
}

BackendPointer Backends::get(config::BackendChoice choice, int threads, MeshMethod method) {
    if (always_) return always_;
    BackendPointer& backend = kept_[{choice, threads, method}];
    if (!backend) backend = pick_backend(choice, threads, method);
    return backend;
}

namespace {

class ReplacedBackend final : public Backend {
    Backend& used() const { return is_replaced_ ? *cpu_ : *device_; }
    // Does the work on the device, or on the CPU if the device fails or has failed before.
    template <typename Work>
    auto attempt(const Work& work) {
        try {
            if (!is_replaced_) return work(*device_);
        } catch (const Error& error) {
            if (error.kind() != ErrorKind::device) throw;
            is_replaced_ = true;
            log_.warn(going_on_without(error.what()));
        }
        return work(*cpu_);
    }

  public:
    ReplacedBackend(BackendPointer device, BackendPointer cpu, RunLog& log)
        : Backend(cpu->threads()), device_(std::move(device)), cpu_(std::move(cpu)), log_(log) {}
    std::string name() const override { return used().name(); }
    std::string device() const override { return used().device(); }
    matching::MatchedMap match_pair(const StereoPair& pair, const matching::MatchingConfig& config) override {
        return attempt([&](Backend& backend) { return backend.match_pair(pair, config); });
    }
    void expect_map(const DisparityMap& map) override { used().expect_map(map); }
    HexMesh2D solve_mesh(const DensityMap& density, const MeshConfig& config,
                         const ProgressFunction& progress) override {
        return attempt([&](Backend& backend) { return backend.solve_mesh(density, config, progress); });
    }
    DisparityMesh cut_disparity_mesh(const surface::DisparityMeshInput& input,
                                     const SurfaceConfig& config) override {
        return attempt([&](Backend& backend) { return backend.cut_disparity_mesh(input, config); });
    }
    void balance_patch(const DensityMap& density, const BalanceConfig& config,
                       balance::LatticePatch& patch) override {
        attempt([&](Backend& backend) { backend.balance_patch(density, config, patch); });
    }
    DeviceFigures figures() const override { return used().figures(); }
    void give_back() override { device_->give_back(); }
    bool is_replaced() const override { return is_replaced_; }

  private:
    BackendPointer device_, cpu_;
    RunLog& log_;
    bool is_replaced_ = false;
};

}  // namespace

std::string going_on_without(const std::string& failure) {
    return failure + "; the CPU goes on";
}

BackendPointer with_replacement(BackendPointer device, BackendPointer cpu, RunLog& log) {
    return std::make_shared<ReplacedBackend>(std::move(device), std::move(cpu), log);
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

double estimated_cpu_seconds(const RunSize& size, const config::Config& config) {
    const double pixels = static_cast<double>(size.width) * size.height;
    const int searched = config.disparity.num_disparities_px;
    const double disparities = searched > 0 ? searched : size.width / kWidthPerDisparity;
    const double spacing = config.mesh.spacing_px;
    const bool on_device = size.is_pair && config.disparity.method == stages::DisparityMethod::sgm;
    const double solves = has_budget(config.budget) ? kBudgetSolves : 1;
    const double one_thread_s = (on_device ? pixels * disparities * kPixelAndDisparity_s : 0) +
                                solves * (pixels * kPixel_s + pixels / (spacing * spacing) * kVertex_s);
    return one_thread_s * (kSerialShare + (1 - kSerialShare) / size.threads);
}

BackendDecision choose_backend(const RunSize& size, const config::Config& config) {
    if (config.run.backend != config::BackendChoice::automatic) return {config.run.backend, "as configured"};
    if (config.mesh.method != MeshMethod::cellular)
        return {config::BackendChoice::cpu, "mesh.method: sequential has no CUDA form"};
    const double cpu_s = size.jobs * estimated_cpu_seconds(size, config);
    const std::string figures = "about " + fixed(cpu_s, 2) + " s on the CPU" +
                                (size.jobs > 1 ? " for " + std::to_string(size.jobs) + " jobs" : "") +
                                ", a device takes " + fixed(kDeviceStart_s, 1) + " s to start";
    if (cpu_s < kDeviceStart_s) return {config::BackendChoice::cpu, figures};
    return {config::BackendChoice::automatic, figures};
}

}  // namespace hexrelief::job
