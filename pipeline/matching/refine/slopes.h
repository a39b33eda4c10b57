// The inclination of the surfaces of a disparity map.
#pragma once

#include "mesher/common/thread_pool.h"
#include "pipeline/matching/common/bordered_raster.h"

namespace hexrelief::matching {

struct Slopes {
    Raster<std::int16_t> x, y;  // 1/256 px of disparity per pixel; no meaning where that is unknown
};

// Of lines fitted to both sides, as far as a surface goes, averaged over the pixels around.
Slopes find_slopes(const Disparities16& map, ThreadPool& pool);

}  // namespace hexrelief::matching
