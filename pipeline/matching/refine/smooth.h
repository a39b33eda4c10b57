// Smooths the unevenness that matching leaves on surfaces.
#pragma once

#include "pipeline/base/thread_pool.h"
#include "pipeline/matching/common/bordered_raster.h"
#include "pipeline/matching/common/color_planes.h"

namespace hexrelief::matching {

// Returns the smoothed map. Unknown pixels stay unknown. Discontinuities of 2 px and more are preserved.
Disparities16 smoothed(const Disparities16& map, const ColorPlanes& colors, ThreadPool& pool);

}  // namespace hexrelief::matching
