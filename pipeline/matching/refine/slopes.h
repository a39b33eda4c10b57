// The slopes of the surfaces of a disparity map.
#pragma once

#include "pipeline/base/thread_pool.h"
#include "pipeline/matching/common/bordered_raster.h"
#include "pipeline/matching/common/color_planes.h"

namespace hexrelief::matching {

struct Slopes {
    Raster<std::int16_t> x, y;  // 1/256 px of disparity per pixel; undefined at unknown pixels
};

// Returns the slopes of lines fitted to both sides of each pixel, as far as its surface extends, averaged
// over the pixels around it, stride_px apart (step::kNearSlopes_px or kFarSlopes_px).
Slopes find_slopes(const Disparities16& map, int stride_px, ThreadPool& pool);

// Returns the smoothed map. Unknown pixels stay unknown. Discontinuities of 2 px and more are preserved.
Disparities16 smoothed(const Disparities16& map, const ColorPlanes& colors, ThreadPool& pool);

}  // namespace hexrelief::matching
