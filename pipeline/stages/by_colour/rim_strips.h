// Joins narrow strips along the rims of near things to these.
#pragma once

#include "pipeline/data/disparity_map.h"

namespace hexrelief::stages {

// Where a near thing turns away or is out of focus, matches leave strips of it a little farther than the
// rest: meshed, they hang beside the thing, and the right picture's colours in the gap lie on what is behind.
// Here they continue the thing. In a row or a column such a strip is at most 1/120 of the longer side wide,
// ends at a step down of more than 1/225 of it (and 2 px), begins at a step down of more than a pixel, and
// has to rise by no more than the first of these. Connected strips that nowhere have to rise by more than
// 1/450 of the longer side stay, as do unknown pixels and origins.
DisparityMap with_rim_strips_joined(DisparityMap map);

}  // namespace hexrelief::stages
