// Runs one job, from its source to its files.
#pragma once

#include <memory>

#include "pipeline/job/backend.h"
#include "pipeline/job/log/run_log.h"
#include "pipeline/job/report.h"
#include "pipeline/job/request.h"

namespace hexrelief::job {

// Make the disparities, or the whole relief, of a request. The places to write are not checked; the outputs'
// names matter only if a budget limits their bytes. The log must outlive the relief's backend. Throw Error.
Relief make_disparities(RunRequest request, Backends& backends, RunLog& log);
Relief make_relief(RunRequest request, Backends& backends, RunLog& log);

// Writes the requested outputs, stages' files and report, all or none. The configuration is the one that the
// relief was made with. Throws Error.
RunReport write_relief(std::shared_ptr<const Relief> relief, const RunRequest& request, RunLog& log);

// Runs the whole job, beginning with check_request(). If it throws, no new file remains. Throws Error.
RunReport run_job(const RunRequest& request, Backends& backends, RunLog& log);
// Runs the job with backends of its own and without callbacks.
RunReport run_job(const RunRequest& request);

}  // namespace hexrelief::job
