// The one place that picks what matches pairs, solves the 2D mesh and cuts it along depth discontinuities.
#pragma once

#include <cstddef>
#include <map>
#include <memory>
#include <string>
#include <tuple>
#include <vector>

#include "mesher/balance/balance.h"
#include "mesher/mesher.h"
#include "pipeline/config/config.h"
#include "pipeline/job/run_log.h"
#include "pipeline/stages/disparity.h"

namespace hexrelief::job {

// CPU threads or a device. All give the same bytes. One call at a time.
class Backend : public stages::PairMatcher {
  public:
    // threads: of the CPU, for the work beside the device's, too.
    explicit Backend(int threads) : threads_(threads) {}
    int threads() const { return threads_; }
    virtual std::string name() const = 0;    // "cpu" or "cuda"
    virtual std::string device() const = 0;  // its make and model

    // Announces the map that the next mesh is cut by: a device copies it while that mesh is solved. The map
    // must stay where and as it is until the mesh is cut.
    virtual void expect_map(const DisparityMap&) {}
    virtual mesher::MeshResult solve_mesh(const DensityMap& density, const MeshConfig& config,
                                          const ProgressFunction& progress) = 0;
    virtual surface::DisparityMeshResult cut_disparity_mesh(const surface::DisparityMeshInput& input,
                                                            const SurfaceConfig& config) = 0;
    // balance_patch() of mesher/balance/balance.h.
    virtual void balance_patch(const DensityMap& density, const BalanceConfig& config,
                               balance::LatticePatch& patch) = 0;

    // Ends the process's use of the device; nothing above but names may be called after it.
    virtual void give_back() {}
    // True once the device has failed and the CPU has gone on in its place.
    virtual bool is_replaced() const { return false; }

    std::string missed;  // of the CPU under auto: why a device that is there cannot be used; else empty

  private:
    int threads_;
};

using BackendPointer = std::shared_ptr<Backend>;

struct DeviceDescription {
    std::string backend;
    std::string name;
    std::string details;  // threads, memory, ...
    bool usable = true;
};

// The threads that `configured` stands for: itself, or for 0 all that the process may use; at least 1. More
// than these, and than 8, are not taken: they would only wait for each other (1024 threads on two cores use
// 28 s of CPU time for a job of 0.15 s; 8 use 0.29 s).
int effective_threads(int configured);

// auto takes CUDA where it is built in, has a usable device and can do the method. Throws Error(device) where
// the choice is not built in or has no usable device.
BackendPointer pick_backend(config::BackendChoice choice, int threads,
                            MeshMethod method = MeshMethod::cellular);

// Where runs get their backends. One call at a time, and one job.
class Backends {
  public:
    // Those of pick_backend(), each kept for the next call that asks for the same: of many jobs only the
    // first waits for the device, and its memory is used again.
    Backends() = default;
    // `always`, whatever is asked for.
    explicit Backends(BackendPointer always) : always_(std::move(always)) {}
    // For a process that ends with the run: its device starts and ends sooner. The driver makes one queue
    // instead of eight (0.14 s for 0.20 on an H200), and the run gives the device back as soon as it can,
    // since it takes 0.08 s to let a device and its driver go, which other work need not wait for. Call this
    // before any other thread starts.
    static Backends for_one_run();

    BackendPointer get(config::BackendChoice choice, int threads, MeshMethod method = MeshMethod::cellular);
    bool ends_with_run() const { return ends_with_run_; }

  private:
    using Key = std::tuple<config::BackendChoice, int, MeshMethod>;
    BackendPointer always_;
    bool ends_with_run_ = false;
    std::map<Key, BackendPointer> kept_;
};

// `device`, until it fails: from then on, the work that failed included, `cpu`, which gives the same bytes.
// The log is warned why, once. For run.backend: auto.
std::string going_on_without(const std::string& failure);  // what is told
BackendPointer with_replacement(BackendPointer device, BackendPointer cpu, RunLog& log);

// The CPU first.
std::vector<DeviceDescription> list_devices();

// From a device's memory, when all work at hand there is done. Throws Error(device), also where CUDA is not
// built in.
void copy_from_device(void* target, const void* source, std::size_t bytes);

// What is known of a run before its work.
struct RunSize {
    int width = 0, height = 0;  // of the map
    bool is_pair = false;       // it has to be matched
    int threads = 1;
    int jobs = 1;  // like this one that the process does, this one included: the device starts once for all
};

struct BackendDecision {
    config::BackendChoice choice =
        config::BackendChoice::automatic;  // automatic: CUDA where a device is usable
    std::string reason;
};

// Seconds that the CPU takes for what a device could do instead: 7 ns a pixel and disparity searched, 85 ns a
// pixel and 4.5 us a vertex of the lattice on one thread, of which a tenth gains nothing from more threads.
// Where the number of disparities is left to the pair, a seventh of the width; a budget takes seven meshes.
// Measured on AMD EPYC cores; right within a factor of two.
double estimated_cpu_seconds(const RunSize& size, const config::Config& config);

// The configured backend where it is not auto. For auto the CPU, where it does that work before a device has
// started, or where only it can do what is asked for.
BackendDecision choose_backend(const RunSize& size, const config::Config& config);

}  // namespace hexrelief::job
