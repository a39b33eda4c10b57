// Unknown pixels filled from the matches around them.
#pragma once

#include "mesher/common/thread_pool.h"
#include "pipeline/matching/refine/consistency.h"
#include "pipeline/matching/refine/slopes.h"

namespace hexrelief {

// matches.left with its unknown pixels filled; those that have no known pixel in any of eight directions stay
// unknown. slopes: of matches.left.
Disparities16 fill_unknown(const TrustedMatches& matches, const Slopes& slopes, int min_px, ThreadPool& pool);

}  // namespace hexrelief
