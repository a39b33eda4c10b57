// Picks what matches pairs, solves the 2D mesh and cuts it along depth discontinuities; no other file does.
#pragma once

#include <cstddef>
#include <map>
#include <memory>
#include <string>
#include <tuple>
#include <vector>

#include "mesher/balance/balance.h"
#include "mesher/common/device_figures.h"
#include "mesher/mesher.h"
#include "pipeline/config/config.h"
#include "pipeline/job/log/run_log.h"
#include "pipeline/job/matchers/program_matcher.h"
#include "pipeline/stages/disparity.h"

namespace hexrelief::job {

// CPU threads or a device. All backends give the same bytes. One call at a time.
class Backend : public stages::PairMatcher {
  public:
    // threads: CPU threads; a device's backend uses them for the work that stays on the CPU.
    explicit Backend(int threads) : threads_(threads) {}
    int threads() const { return threads_; }
    virtual std::string name() const = 0;    // "cpu" or "cuda"
    virtual std::string device() const = 0;  // make and model

    // Announces the map that the next mesh is cut by, so that a device can copy the map while it solves that
    // mesh. The map must stay unchanged, at the same address, until the mesh is cut.
    virtual void expect_map(const DisparityMap&) {}
    virtual HexMesh2D solve_mesh(const DensityMap& density, const MeshConfig& config,
                                 const ProgressFunction& progress) = 0;
    virtual DisparityMesh cut_disparity_mesh(const surface::DisparityMeshInput& input,
                                             const SurfaceConfig& config) = 0;
    // Calls balance_patch() of mesher/balance/balance.h.
    virtual void balance_patch(const DensityMap& density, const BalanceConfig& config,
                               balance::LatticePatch& patch) = 0;

    // Returns the device's figures of the latest solve_mesh() and cut_disparity_mesh().
    virtual DeviceFigures figures() const { return {}; }

    // Ends the process's use of the device. After this call only name() and device() may be called.
    virtual void give_back() {}
    // True once the device has failed and the CPU has taken over.
    virtual bool is_replaced() const { return false; }

    std::string missed;  // why auto fell back to the CPU although a device exists; empty = no such reason

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

// Returns the number of threads to use, at least 1: `configured`, or all that the process may use if
// `configured` is 0. The result is limited to the larger of these usable threads and 8, because more only
// wait for each other (1024 threads on two cores use 28 s of CPU time for a job of 0.15 s; 8 use 0.29 s).
int effective_threads(int configured);

// Returns CUDA for auto if this build has CUDA, a device is usable and CUDA supports the method; else the
// CPU. Throws Error(device) if CUDA is asked for and this build lacks it or no device is usable.
BackendPointer pick_backend(config::BackendChoice choice, int threads,
                            MeshMethod method = MeshMethod::cellular);

// Hands out backends and keeps them for later runs. One call at a time, and one job at a time.
class Backends {
  public:
    // get() returns the backends of pick_backend() and keeps each for the next call with the same arguments:
    // of many jobs only the first waits for the device to start, and its memory is reused.
    Backends() = default;
    // get() returns `always` whatever its arguments are.
    explicit Backends(BackendPointer always) : always_(std::move(always)) {}
    // For a process that ends with the run: its device starts and ends sooner. The driver makes one
    // queue instead of eight (0.14 s instead of 0.20 s on an H200). The run gives the device back as
    // soon as it can, because this takes 0.08 s, during which other work can go on. Call this function
    // before any other thread starts.
    static Backends for_one_run();

    BackendPointer get(config::BackendChoice choice, int threads, MeshMethod method = MeshMethod::cellular);
    bool ends_with_run() const { return ends_with_run_; }
    // The user's programs that match pairs; a worker is kept from run to run.
    ProgramMatcher& programs() { return *programs_; }

  private:
    using Key = std::tuple<config::BackendChoice, int, MeshMethod>;
    BackendPointer always_;
    std::unique_ptr<ProgramMatcher> programs_ = std::make_unique<ProgramMatcher>();
    bool ends_with_run_ = false;
    std::map<Key, BackendPointer> kept_;
};

// Returns a backend that uses `device` until the device fails, then repeats the failed work on `cpu` and
// stays there; the bytes are the same. Warns the log once, with the reason. For run.backend: auto.
std::string going_on_without(const std::string& failure);  // text of that warning
BackendPointer with_replacement(BackendPointer device, BackendPointer cpu, RunLog& log);

// Returns the CPU first, then the devices.
std::vector<DeviceDescription> list_devices();

// Copies from a device's memory after all pending work there is done. Throws Error(device), also if
// this build lacks CUDA.
void copy_from_device(void* target, const void* source, std::size_t bytes);

// Facts about a run that are known before its work begins.
struct RunSize {
    int width = 0, height = 0;  // of the map, px
    bool is_pair = false;       // true if the input must be matched
    int threads = 1;
    int jobs = 1;  // similar jobs of this process, including this one; they share one start of the device
};

struct BackendDecision {
    config::BackendChoice choice = config::BackendChoice::automatic;  // automatic: CUDA if usable
    std::string reason;
};

// Estimates the CPU time, in seconds, of the work that a device could do instead: on one thread 7 ns per
// pixel and disparity searched, 85 ns per pixel and 4.5 us per lattice vertex; a tenth of it does not become
// faster with more threads. If the pair decides the number of disparities, a seventh of the width is assumed;
// a budget counts as seven meshes. Measured on AMD EPYC cores; right within a factor of two.
double estimated_cpu_seconds(const RunSize& size, const config::Config& config);

// Returns the configured backend unless it is auto. For auto, returns the CPU if the CPU does the work before
// a device would have started, or if only the CPU supports what is asked for; else automatic.
BackendDecision choose_backend(const RunSize& size, const config::Config& config);

}  // namespace hexrelief::job
