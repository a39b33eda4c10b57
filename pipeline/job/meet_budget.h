// The relief that keeps a budget.
#pragma once

#include <filesystem>
#include <vector>

#include "pipeline/job/steps.h"

namespace hexrelief {

bool has_budget(const BudgetConfig& budget);

// make_relief() at other spacings and tolerances until it keeps the configured limit (budget.h); what was
// found is in the relief's configuration. Bytes are those of the largest of `outputs`. Throws Error(usage)
// where the limit is out of reach.
Relief meet_budget(const LeftView& view, const Config& config,
                   const std::vector<std::filesystem::path>& outputs, const RunContext& run);

}  // namespace hexrelief
