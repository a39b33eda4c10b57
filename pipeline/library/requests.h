// A run by files, as the library is asked for it and as the pipeline takes it.
#pragma once

#include <hexrelief/run.h>

#include "pipeline/job/report.h"
#include "pipeline/job/request.h"

namespace hexrelief {

// Throws Error(usage), also for files that do not go together.
RunRequest request_of(const FileRequest& files, const Options& options);

RunSummary summary_of(const RunReport& report);

}  // namespace hexrelief
