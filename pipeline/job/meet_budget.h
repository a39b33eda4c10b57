// Searches for the surface that keeps a budget.
#pragma once

#include <filesystem>
#include <vector>

#include "pipeline/job/relief.h"

namespace hexrelief::job {

// Repeats make_surface() with other spacings and tolerances until the surface keeps the configured limit
// (budget.h). The result's configuration and budget hold what was found. A limit on bytes applies to the
// largest of `outputs`. Throws Error(usage) if the limit is out of reach.
SurfaceResult meet_budget(const LeftView& view, const config::Config& config,
                          const std::vector<std::filesystem::path>& outputs, Backend& backend, RunLog& log);

}  // namespace hexrelief::job
