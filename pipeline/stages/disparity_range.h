// The range of disparities that a pair has.
#pragma once

#include "pipeline/data/disparity_map.h"
#include "pipeline/matching/matcher.h"

namespace hexrelief {

// Where the range searched comes from: the pair itself, the configuration, or the calibration's ndisp.
enum class RangeOrigin { chosen, given, ndisp };

struct ReducedPair {
    double scale = 1;  // full columns to a reduced one
    StereoPair pair;
};

// What both views of a reduced pair agree on.
struct SmallMatch {
    ReducedPair small;
    int min_px = 0;  // of the reduced pair: the map's disparities count from here
    MatchedMap map;
};

// The pair at 160 columns, or its own where it has fewer, matched from min_px on over its whole width. Both
// images have one size and at least 16 columns.
SmallMatch match_coarsely(const StereoPair& pair, int min_px, int threads);

// How many disparities from min_px on hold the pair's: a multiple of 16, at most the width. What the coarse
// match from min_px on finds is matched larger over somewhat more; the largest disparity that more than a few
// pixels have in both views is widened by a margin. A wider range costs time and false matches, a narrower
// one loses what is near. A quarter of the width where next to nothing matches.
int choose_num_disparities(const StereoPair& pair, const SmallMatch& coarse, int min_px, int threads);

// Below it, in px of the full pair (whole 1/16), small patches of matches are not to be trusted: the least
// disparity that more than a few pixels of the coarse match have, less a margin. NaN where next to nothing
// matches. What one camera alone sees, beside the frame or behind what is near, may match anything, often as
// something far.
double farthest_disparity_px(const SmallMatch& coarse);

}  // namespace hexrelief
