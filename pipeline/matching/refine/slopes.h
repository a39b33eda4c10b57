// The slopes of the surfaces of a disparity map.
#pragma once

#include "pipeline/base/thread_pool.h"
#include "pipeline/matching/common/bordered_raster.h"

namespace hexrelief::matching {

struct Slopes {
    Raster<std::int16_t> x, y;  // 1/256 px of disparity per pixel; undefined at unknown pixels
};

// Returns the slopes of lines fitted to both sides of each pixel, as far as its surface extends, averaged
// over the pixels around it.
Slopes find_slopes(const Disparities16& map, ThreadPool& pool);

}  // namespace hexrelief::matching
