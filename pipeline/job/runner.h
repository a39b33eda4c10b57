// One job, from files to files.
#pragma once

#include <memory>

#include "pipeline/job/backend.h"
#include "pipeline/job/report.h"
#include "pipeline/job/request.h"
#include "pipeline/job/run_log.h"

namespace hexrelief::job {

// From the source to its disparities, and on to the surface, for a request whose places to write are not
// looked at, but for the outputs' names where a budget limits their bytes. The log outlives the relief's
// backend. Throw Error.
Relief make_disparities(RunRequest request, Backends& backends, RunLog& log);
Relief make_relief(RunRequest request, Backends& backends, RunLog& log);

// Writes the outputs, the stages' files and the report that the request names, all or none. The configuration
// is the one that the relief was made with. Throws Error.
RunReport write_relief(std::shared_ptr<const Relief> relief, const RunRequest& request, RunLog& log);

// Does the job, check_request included: the whole pipeline, from a pair or a map to the files written. Where
// it throws, no new file is left behind. Throws Error.
RunReport run_job(const RunRequest& request, Backends& backends, RunLog& log);
// With backends of its own, and nobody told.
RunReport run_job(const RunRequest& request);

}  // namespace hexrelief::job
