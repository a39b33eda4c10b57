// Brings a map that a program of the user's gave for a pair to that pair's pixels.
#pragma once

#include <string>

#include "pipeline/data/disparity_map.h"

namespace hexrelief::job {

// Changes the map, if necessary, so that it has the left picture's size and left(x, y) = right(x - d, y): it
// is brought to that size, its disparities with it, and the sign is turned, if that fits the pictures clearly
// better by a sample of pixels. Returns what was done; empty = nothing. Throws Error(input) if the map has
// another shape than the pictures.
std::string fit_answer(DisparityMap& map, const StereoPair& pair);

}  // namespace hexrelief::job
