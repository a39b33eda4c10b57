// From a pair on the host to its disparities on the host.
#pragma once

#include "cuda/common/arena.h"
#include "cuda/common/staging.h"
#include "cuda/matching/common/stage_clock.h"
#include "pipeline/matching/matcher.h"

namespace hexrelief::cuda {

// The same bytes as hexrelief::match_pair(). Resets the arena. clock: begins between the transfers.
MatchedMap match_pair(cudaStream_t stream, Arena& arena, Staging& staging, StageClock& clock,
                      const StereoPair& pair, const MatchingConfig& config);

}  // namespace hexrelief::cuda
