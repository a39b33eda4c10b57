// Fits maps to pictures whose sides a network rounded.
#pragma once

#include <string>

#include "pipeline/data/depth_map.h"
#include "pipeline/data/disparity_map.h"
#include "pipeline/readers/depth/mask_reader.h"

namespace hexrelief::job {

// Changes a map whose aspect differs from its picture's: cuts it evenly if it is the picture padded to
// multiples of 8 to 128, or repeats and leaves out rows if the aspect is at most 3 % off, as after rounding
// to multiples of 14 or 16. Columns stay, and so disparities. Returns what was done; empty = nothing.
std::string fit_to_picture(DisparityMap& map, int width, int height);
std::string fit_to_picture(DepthMap& map, int width, int height);
std::string fit_to_picture(readers::PixelMask& mask, int width, int height);

}  // namespace hexrelief::job
