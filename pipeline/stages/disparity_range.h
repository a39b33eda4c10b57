// The range of disparities that a pair has.
#pragma once

#include "pipeline/data/disparity_map.h"

namespace hexrelief {

// How many disparities from min_px on hold the pair's: a multiple of 16, at most the width. The pair is
// matched small over its whole width, then larger over somewhat more than was found; the largest disparity
// that more than a few pixels have in both views is widened by a margin. A wider range costs time and false
// matches, a narrower one loses what is near. A quarter of the width where next to nothing matches.
int choose_num_disparities(const StereoPair& pair, int min_px, int threads);

}  // namespace hexrelief
