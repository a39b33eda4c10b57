// One job, from files to files.
#pragma once

#include "pipeline/job/backend.h"
#include "pipeline/job/report.h"
#include "pipeline/job/request.h"
#include "pipeline/job/run_log.h"

namespace hexrelief {

// Does the job, check_request included: the whole pipeline, from a pair or a map to the files written. Where
// it throws, no new file is left behind. Throws Error.
RunReport run_job(const RunRequest& request, const RunObserver& observer,
                  const BackendPicker& pick = pick_backend);

}  // namespace hexrelief
