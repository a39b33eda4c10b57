// Tells whether a unit's outputs are those that its inputs and configuration lead to.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "pipeline/job/request.h"

namespace hexrelief::job {

// Returns the SHA-256 of everything that the outputs' bytes depend on: the bytes of the source's files
// and of the calibration, the effective configuration, the outputs' names without their folders, and the
// program's version. Threads, backend and folders change no byte and are left out. Throws Error(input) if a
// file cannot be read.
std::string unit_stamp(const RunRequest& request);

enum class UnitState {
    missing,  // no report, or one without a stamp
    changed,  // an input, the configuration or the version changed, or an output is not as it was written
    current,  // everything is in place, and the outputs have the bytes that the report states
};

// Reads a report or another JSON object of this program, which others may have written; null if there is
// none, or it is no JSON object, larger than 64 MiB or nested too deeply.
nlohmann::ordered_json read_json(const std::filesystem::path& path);

// Compares the stamp with the request's report, which is the last of its files to be written.
UnitState unit_state(const RunRequest& request, const std::string& stamp);

// Sets the request's stamp and returns its state; `missing`, without a stamp, if the request names no report.
// Throws what unit_stamp() throws.
UnitState stamp_request(RunRequest& request);

}  // namespace hexrelief::job
