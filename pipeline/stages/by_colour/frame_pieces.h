// Joins small pieces at the left end of a photograph's map to what is beside them.
#pragma once

#include "pipeline/data/disparity_map.h"

namespace hexrelief::stages {

// The right camera does not see what is at the left picture's left border: small pieces there have
// disparities of their own, and turned they stand out as flags and spikes, or leave white notches. Here they
// join what is beside them: what stands at a row's left end, or at a column's end, in front of what follows,
// and what in a column is nearer or farther than the surface above and below. A piece starts with a step of
// 1/225 (nearer) or 1/450 (farther) of the longer side, at least 2 px; is at most 1/25 of it long along that
// row or column; comes within 1/100 of it of the left end of a row; and is filled, not matched, to 2/3
// (nearer) or 1/4 (farther: or smaller than 1/1700 of the picture). Unknown pixels, origins, and maps without
// origins stay. The same for any number of threads.
DisparityMap with_frame_pieces_joined(DisparityMap map, int threads);

}  // namespace hexrelief::stages
