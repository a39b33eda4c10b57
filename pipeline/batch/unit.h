// Runs one unit of a batch, unless it is up to date.
#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include "pipeline/batch/manifest.h"
#include "pipeline/job/backend.h"
#include "pipeline/job/request.h"

namespace hexrelief::batch {

// Converts the options of `hexrelief run` to a request. Throws Error.
using RequestParser = std::function<job::RunRequest(const std::vector<std::string>& words)>;

enum class UnitOutcome { done, up_to_date, would_run, failed };
std::string outcome_name(UnitOutcome outcome);  // "done", "up_to_date", "would_run", "failed"

struct UnitResult {
    UnitOutcome outcome = UnitOutcome::failed;
    double seconds = 0;
    std::size_t peak_bytes = 0;              // peak memory of the process that ran the unit; 0 = unknown
    int exit_code = 0;                       // the exit code of `hexrelief run`
    std::string message = {};                // one line: why the unit failed, or why it would run; else empty
    std::vector<std::string> warnings = {};  // a line each, of a unit that ran, whether it failed or not
};

struct UnitRules {
    RequestParser parse;
    bool force = false;    // also run units that are up to date
    bool dry_run = false;  // write nothing
    int threads = 1;       // for units that name none
    int jobs = 1;          // number that a process is likely to run: they share a device's start-up
};

// Runs a unit unless it is up to date. A unit without a report is never up to date. Never throws: the
// result holds the failure.
UnitResult do_unit(const BatchUnit& unit, const UnitRules& rules, job::Backends& backends);

// Returns the message and exit code for the current exception. Call it in a catch block.
UnitResult result_of_exception();

}  // namespace hexrelief::batch
