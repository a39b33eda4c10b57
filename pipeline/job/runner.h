// One job, from files to files.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "pipeline/config/config.h"
#include "pipeline/job/report.h"

namespace hexrelief {

// Either left and right, or disparity (with color or without).
struct RunRequest {
    std::filesystem::path left, right;
    std::filesystem::path disparity, color;
    Config config;
    std::vector<std::filesystem::path> outputs;  // share the work; the extension gives the format
    std::filesystem::path report;                // empty = none
    std::filesystem::path stages_folder;         // empty = none
};

// Told what happens; every function may be empty.
struct RunObserver {
    std::function<void(const std::string& stage)> stage_begins;
    std::function<void(double share)> stage_progresses;
    std::function<void(const std::string& stage, double seconds)> stage_ends;
    std::function<void(const std::string& decision)> decides;
    std::function<void(const std::string& warning)> warns;
};

// Everything that can be known to fail before the work: throws Error(usage) for wrong combinations, unknown
// extensions, an output that is named twice or is an input, and Error(output) for a place that cannot be
// written.
void check_request(const RunRequest& request);

// Does the job, check_request included. Where it throws, no new file is left behind. Throws Error.
RunReport run_job(const RunRequest& request, const RunObserver& observer);

}  // namespace hexrelief
