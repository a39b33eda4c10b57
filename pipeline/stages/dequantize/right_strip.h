// Continues surfaces beyond the right picture's right end.
#pragma once

#include "pipeline/data/disparity_map.h"

namespace hexrelief::stages {

// Of two photographs that are turned until their rows agree, the right one may end before the left view does.
// What would lie beyond its end matches nothing, or, if bare, what is nearer and still inside, and is filled
// from nearer things. Here each row's surface goes on to the right from where it would leave the right
// picture, until matched pixels over at least a 60th of the longer side are another surface. is_seen: of the
// right picture, the map's size, 1 = shows something; empty = all. Maps without origins stay.
DisparityMap continued_at_right_end(DisparityMap map, const std::vector<std::uint8_t>& is_seen);

}  // namespace hexrelief::stages
