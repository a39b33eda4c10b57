// From a pair on the host to its disparities on the host.
#pragma once

#include "cuda/matching/common/workspace.h"
#include "pipeline/matching/matcher.h"

namespace hexrelief::cuda {

// The same bytes as hexrelief::match_pair(). Resets the arena; the clock begins between the transfers.
MatchedMap match_pair(Workspace& work, const StereoPair& pair, const MatchingConfig& config);

}  // namespace hexrelief::cuda
