// One unit of a batch, done or found done.
#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include "pipeline/batch/manifest.h"
#include "pipeline/job/backend.h"
#include "pipeline/job/request.h"

namespace hexrelief {

// Makes of the options of `hexrelief run` what is asked for. Throws Error.
using RequestParser = std::function<RunRequest(const std::vector<std::string>& words)>;

enum class UnitOutcome { done, up_to_date, would_run, failed };
std::string outcome_name(UnitOutcome outcome);  // "done", "up_to_date", "would_run", "failed"

struct UnitResult {
    UnitOutcome outcome = UnitOutcome::failed;
    double seconds = 0;
    std::size_t peak_bytes = 0;  // of the memory of the process that did it; 0 = not known
    int exit_code = 0;           // as `hexrelief run` would have given it
    std::string message = {};    // one line: why it failed, or why it is to be done; else empty
};

struct UnitRules {
    RequestParser parse;
    bool force = false;    // what is up to date is done again
    bool dry_run = false;  // nothing is written
    bool strict = false;   // as --strict for each unit
    int threads = 1;       // of a unit that names none
    int jobs = 1;          // that a process is likely to do: they share a device's start-up
};

// Never throws: what fails is told in the result. A unit without a report is always done: nothing says that
// it was.
UnitResult do_unit(const BatchUnit& unit, const UnitRules& rules, Backends& backends);

// What the program says, and its exit code, for an exception at hand. Call it in a catch block.
UnitResult result_of_exception();

}  // namespace hexrelief
