// Checks the meaning of a run's input before the work.
#pragma once

#include "pipeline/job/input.h"
#include "pipeline/stages/disparity.h"

namespace hexrelief::job {

// Warns of likely mistakes in a pair or a map, its picture or its camera. range: the range found for a pair.
// Throws Error(input) with the same text if run.strict is set.
void check_input(const RunInput& input, const stages::FoundRange& range, const config::Config& config,
                 int threads, RunLog& log);

}  // namespace hexrelief::job
