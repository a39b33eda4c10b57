// Unknown pixels filled from the matches around them.
#pragma once

#include "pipeline/matching/refine/consistency.h"
#include "pipeline/matching/refine/slopes.h"

namespace hexrelief {

// matches.left with its unknown pixels filled; all unknown where nothing is known. slopes: of matches.left.
Disparities16 fill_unknown(const TrustedMatches& matches, const Slopes& slopes, int min_px, ThreadPool& pool);

}  // namespace hexrelief
