// The runs of a triangle's pixels, eight rows side by side.
#pragma once

#include <span>
#include <vector>

#include "mesher/surface/topology/rasterize_step.h"

namespace hexrelief {

// Those that each_run() visits, in its order; empty ones may lie elsewhere in their rows. They lie in `room`,
// which grows where they need more, and hold until it is used again.
std::span<const PixelRun> find_runs(int width, int height, const Vec2f& a, const Vec2f& b, const Vec2f& c,
                                    std::vector<PixelRun>& room);

}  // namespace hexrelief
