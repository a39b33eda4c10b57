// Finds a triangle's pixels, several rows at a time.
#pragma once

#include <span>
#include <vector>

#include "mesher/surface/topology/rasterize_step.h"
#include "pipeline/data/geometry.h"

namespace hexrelief::surface {

// Returns the pixels of a triangle as TriangleRows does, one run per row from the first row on. The position
// of a run without pixels within its row may differ. The runs are stored in `buffer`, which grows as needed.
std::span<const PixelRun> find_runs(int width, int height, const Vec2f& a, const Vec2f& b, const Vec2f& c,
                                    std::vector<PixelRun>& buffer);

}  // namespace hexrelief::surface
