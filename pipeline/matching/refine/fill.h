// Fills unknown pixels from the matches around them.
#pragma once

#include "pipeline/base/thread_pool.h"
#include "pipeline/matching/common/color_planes.h"
#include "pipeline/matching/refine/consistency.h"
#include "pipeline/matching/refine/slopes.h"

namespace hexrelief::matching {

struct FillInput {
    const TrustedMatches& matches;
    const Slopes& slopes;  // slopes of matches.left
    const PairColors& colors;
    int min_px;
};

// Returns matches.left with its unknown pixels filled. Pixels without a known pixel in any of the
// eight directions stay unknown.
Disparities16 fill_unknown(const FillInput& input, ThreadPool& pool);

}  // namespace hexrelief::matching
