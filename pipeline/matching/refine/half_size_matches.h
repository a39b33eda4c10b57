// Adds the matches at half size to those at full size.
#pragma once

#include "pipeline/base/thread_pool.h"
#include "pipeline/matching/refine/consistency.h"

namespace hexrelief::matching {

struct HalfSizeMatches {
    Disparities16 left;  // trusted, in 1/16 px (of half size) above min_px
    int min_px = 0;
};

// Sets unknown pixels of matches.left. min_px is the least disparity of the range at full size.
void add_half_size_matches(const HalfSizeMatches& half, int min_px, TrustedMatches& matches,
                           ThreadPool& pool);

}  // namespace hexrelief::matching
