// Converts the library's requests to the pipeline's, and the pipeline's results to the library's.
#pragma once

#include <hexrelief/run.h>

#include "pipeline/job/report.h"
#include "pipeline/job/request.h"

namespace hexrelief::library {

// Returns the request of a run. Throws Error(usage).
job::RunRequest request_of(const FileRequest& files, const Options& options);

RunSummary summary_of(const job::RunReport& report);

}  // namespace hexrelief::library
