// Where the fit begins.
#pragma once

#include <vector>

#include "pipeline/alignment/views.h"

namespace hexrelief::alignment {

// Returns the parameters of cameras that stand parallel; that are turned so that the matches lie on the same
// rows on average; and that are turned towards the same places as well. Needs at least 2 matches.
std::vector<Parameters> starts_of(const Camera& camera, const std::vector<Match>& matches);

}  // namespace hexrelief::alignment
