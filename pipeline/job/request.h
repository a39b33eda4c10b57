// What a run is asked for.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "pipeline/config/config.h"

namespace hexrelief::job {

// Either left and right, or stereo, which holds both, or disparity or depth (with color or without).
struct RunRequest {
    std::filesystem::path left, right, stereo;
    std::filesystem::path disparity, depth, color;
    std::filesystem::path mask, confidence;  // of the left view; confidences of a map alone
    config::Config config;
    std::filesystem::path config_file;           // that config was read from; empty = none
    std::vector<std::filesystem::path> outputs;  // share the work; the extension gives the format
    std::filesystem::path report;                // empty = none
    std::filesystem::path stages_folder;         // empty = none
    std::filesystem::path depfile;               // for make: what the outputs are made from; empty = none
    std::string stamp;  // told in the report: of all that the outputs depend on (stamp.h); empty = not
    int jobs = 1;       // that this process does, this one included: they share a device's start-up
};

// Everything that can be known to fail before the work: throws Error(usage) for wrong combinations, unknown
// extensions, an output that is named twice or is an input, Error(output) for a place that cannot be written,
// and Error(input) for a run that is estimated to take more memory than limits.max_memory.
void check_request(const RunRequest& request);

}  // namespace hexrelief::job
