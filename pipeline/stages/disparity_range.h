// Estimates the range of a pair's disparities.
#pragma once

#include "pipeline/data/disparity_map.h"
#include "pipeline/matching/matcher.h"

namespace hexrelief::stages {

// The origin of the searched range: the pair itself, the configuration, or the calibration's ndisp.
enum class RangeOrigin { chosen, given, ndisp };

struct ReducedPair {
    double scale = 1;  // columns of the full pair per column of the reduced one
    StereoPair pair;
};

// The disparities that both views of a reduced pair agree on.
struct SmallMatch {
    ReducedPair small;
    int min_px = 0;  // in px of the reduced pair: the map's disparities count from here
    matching::MatchedMap map;
};

// Matches the pair at 160 columns (or at its own width if that is less), from min_px on over its whole width.
// Both images must have one size and at least 16 columns.
SmallMatch match_coarsely(const StereoPair& pair, int min_px, int threads);

// Chooses how many disparities from min_px on cover the pair: a multiple of 16, at most the width. The pair
// is matched again at a larger size, over somewhat more than the range that the coarse match found. The
// largest disparity that more than a few pixels have in both views is then widened by a margin: a wider range
// costs time and gives false matches, a narrower one loses near surfaces. Returns a quarter of the width if
// next to nothing matches.
int choose_num_disparities(const StereoPair& pair, const SmallMatch& coarse, int min_px, int threads);

// Returns the disparity, in px of the full pair (a multiple of 1/16), below which small patches of matches
// are not trusted: the least disparity that more than a few pixels of the coarse match have, less a margin.
// NaN if next to nothing matches. The reason: pixels that only one camera sees, beside the frame or behind a
// near surface, may match anything, often something far.
double farthest_disparity_px(const SmallMatch& coarse);

}  // namespace hexrelief::stages
