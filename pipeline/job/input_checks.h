// What the inputs of a run mean is looked at before the work.
#pragma once

#include "pipeline/job/input.h"
#include "pipeline/stages/disparity.h"

namespace hexrelief::job {

// Warns of what a pair, a map, their picture or their camera seems to be wrong in; range: of a pair. Throws
// Error(input) with the same text where run.strict asks for that.
void check_input(const RunInput& input, const stages::FoundRange& range, const config::Config& config,
                 int threads, RunLog& log);

}  // namespace hexrelief::job
