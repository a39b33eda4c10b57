// One job, from files to files.
#pragma once

#include <functional>
#include <string>

#include "pipeline/job/backend.h"
#include "pipeline/job/input.h"
#include "pipeline/job/report.h"
#include "pipeline/job/request.h"
#include "pipeline/job/run_log.h"
#include "pipeline/job/steps.h"

namespace hexrelief::job {

// What a run makes of its input, before anything is written.
struct Relief {
    RunInput input;
    Backend backend;
    std::string backend_reason;
    int threads = 1;
    DisparityResult disparity;
    DensityMap density;
    SurfaceResult result;

    // Refers to this.
    LeftView view() const;
};

// Gives a run what it works on: read_input(), or what is in memory.
using InputSource = std::function<RunInput(int threads, RunLog& log)>;

// From a pair or a map to its disparities, and on to the surface. Of the request only the configuration, the
// outputs' names (for a budget of bytes), whether the map is one of depths, and the jobs count. Throw Error.
Relief make_disparities(const InputSource& read, const RunRequest& request, const BackendPicker& pick,
                        RunLog& log);
Relief make_relief(const InputSource& read, const RunRequest& request, const BackendPicker& pick,
                   RunLog& log);

// Writes the outputs, the stages' files and the report that the request names, all or none. The configuration
// is the one that the relief was made with. Throws Error.
RunReport write_relief(const Relief& relief, const RunRequest& request, RunLog& log);

// Does the job, check_request included: the whole pipeline, from a pair or a map to the files written. Where
// it throws, no new file is left behind. Throws Error.
RunReport run_job(const RunRequest& request, const RunObserver& observer,
                  const BackendPicker& pick = pick_backend);

}  // namespace hexrelief::job
