// A run by files, as the library is asked for it and as the pipeline takes it.
#pragma once

#include <hexrelief/run.h>

#include "pipeline/job/report.h"
#include "pipeline/job/request.h"

namespace hexrelief::library {

// Throws Error(usage).
job::RunRequest request_of(const FileRequest& files, const Options& options);

RunSummary summary_of(const job::RunReport& report);

}  // namespace hexrelief::library
