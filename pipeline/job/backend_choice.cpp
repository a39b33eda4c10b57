#include "pipeline/job/backend.h"
#include "pipeline/job/budget/budget.h"
#include "pipeline/job/log/run_log.h"

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

}  // namespace

double estimated_cpu_seconds(const RunSize& size, const config::Config& config) {
    const double pixels = static_cast<double>(size.width) * size.height;
    const int searched = config.disparity.num_disparities_px;
    const double disparities = searched > 0 ? searched : size.width / kWidthPerDisparity;
    const double spacing = config.mesh.spacing_px;
    const bool on_device = size.is_pair && config.disparity.method == stages::DisparityMethod::sgm;
    const double solves = job::has_budget(config.budget) ? kBudgetSolves : 1;
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
