// One run as a command line asks for it.
#pragma once

#include <hexrelief/run.h>

#include <optional>
#include <string>

#include "pipeline/cli/arguments/config_options.h"
#include "pipeline/cli/commands.h"

namespace hexrelief::cli {

struct RunOptions {
    FileRequest request;
    config::ConfigOptions config;
    std::optional<double> scale, offset_px, fov_x_deg;
    std::string unknown, depth_unit, depth_kind, key, calibration, layout, backend;
    std::optional<int> threads;
    std::optional<long long> seed, vertices, max_bytes;
    std::optional<double> max_error_px;
    bool quiet = false, verbose = false, strict = false;
};

void add_run_options(Command& command, RunOptions& options);

// What the options say beside the files. Throws Error(usage).
Options options_of(const RunOptions& options);

// Throw as the library's check_run() and run(). The second prints what was asked for.
void check_run(const RunOptions& options);
void run_and_tell(const RunOptions& options);

}  // namespace hexrelief::cli
