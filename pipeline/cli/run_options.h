// One run as a command line asks for it.
#pragma once

#include <optional>
#include <string>

#include "pipeline/cli/arguments.h"
#include "pipeline/config/options.h"
#include "pipeline/job/runner.h"

namespace hexrelief {

struct RunOptions {
    RunRequest request;
    ConfigOptions config;
    std::optional<double> scale, offset_px, fov_x_deg;
    std::string unknown, depth_unit, depth_kind, key, calibration, layout, backend;
    std::optional<int> threads;
    std::optional<long long> seed, vertices, max_bytes;
    std::optional<double> max_error_px;
    bool quiet = false, verbose = false, strict = false;
};

void add_run_options(Command& command, RunOptions& options);

// Throws Error(usage).
RunRequest request_of(const RunOptions& options);

// Does the job and prints what was asked for. Throws as run_job().
void run_and_tell(const RunRequest& request, const RunOptions& options, const BackendPicker& pick);

}  // namespace hexrelief
