// Whether a unit's outputs are those that its inputs and configuration lead to.
#pragma once

#include <string>

#include "pipeline/job/request.h"

namespace hexrelief::stamp {

// SHA-256 over all that the outputs' bytes depend on: the bytes of all files read, the effective
// configuration, the outputs' names without their folders, and the program's version. Threads, backend and
// the folders change no byte, and are left out. Throws Error(input) where a file cannot be read.
std::string unit_stamp(const job::RunRequest& request);

enum class UnitState {
    missing,  // no report, or one without a stamp
    changed,  // an input, the configuration or the version is another, or an output is not as it was written
    current,  // all are where the request has them, the outputs with the bytes that the report tells
};

// By the report of the request, which is the last of its files to be written.
UnitState unit_state(const job::RunRequest& request, const std::string& stamp);

// Gives a request that names a report its stamp, and says what state it is in; missing where it names none.
// Throws as unit_stamp().
UnitState stamp_request(job::RunRequest& request);

}  // namespace hexrelief::stamp
