// The surface that keeps a budget.
#pragma once

#include <filesystem>
#include <vector>

#include "pipeline/job/steps.h"

namespace hexrelief::job {

// make_surface() at other spacings and tolerances until it keeps the configured limit (budget.h); what was
// found is in the result's configuration and budget. Bytes are those of the largest of `outputs`. Throws
// Error(usage) where the limit is out of reach.
SurfaceResult meet_budget(const LeftView& view, const config::Config& config,
                          const std::vector<std::filesystem::path>& outputs, Backend& backend, RunLog& log);

}  // namespace hexrelief::job
