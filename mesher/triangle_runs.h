// The runs of a triangle's pixels, a side after the other.
#pragma once

#include <vector>

#include "mesher/steps/triangle_pixels.h"

namespace hexrelief {

// Adds those that each_run() visits, in its order; empty ones may lie elsewhere in their rows.
void add_runs(int width, int height, const Vec2f& a, const Vec2f& b, const Vec2f& c,
              std::vector<PixelRun>& runs);

}  // namespace hexrelief
