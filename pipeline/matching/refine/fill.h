// Fills unknown pixels from the matches around them.
#pragma once

#include "pipeline/base/thread_pool.h"
#include "pipeline/matching/common/color_planes.h"
#include "pipeline/matching/refine/consistency.h"
#include "pipeline/matching/refine/slopes.h"

namespace hexrelief::matching {

struct HalfSizeMatches {
    Disparities16 left;  // trusted, in 1/16 px (of half size) above min_px
    int min_px = 0;
};

// Sets unknown pixels of matches.left. min_px is the least disparity of the range at full size.
void add_half_size_matches(const HalfSizeMatches& half, int min_px, TrustedMatches& matches,
                           ThreadPool& pool);

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
