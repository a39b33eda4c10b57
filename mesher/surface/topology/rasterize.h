// Finds a triangle's pixels, several rows at a time.
#pragma once

#include <span>
#include <vector>

#include "mesher/surface/topology/rasterize_step.h"
#include "pipeline/data/geometry.h"

namespace hexrelief::surface {

// The pixels of TriangleRows, a run in each of its rows, from the first row on; runs without pixels may stand
// elsewhere in their row. They lie in `buffer`, which grows as they need.
std::span<const PixelRun> find_runs(int width, int height, const Vec2f& a, const Vec2f& b, const Vec2f& c,
                                    std::vector<PixelRun>& buffer);

}  // namespace hexrelief::surface
