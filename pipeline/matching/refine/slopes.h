// The inclination of the surfaces of a disparity map.
#pragma once

#include "pipeline/matching/common/raster.h"

namespace hexrelief {

class ThreadPool;

struct Slopes {
    Raster<std::int16_t> x, y;  // 1/256 px of disparity per pixel; no meaning where that is unknown
};

// Lines are fitted over at most 4 or 5 px to both sides, as far as disparities change by at most that much
// from pixel to pixel.
struct SlopeReach {
    int samples = 4;        // 4 or 5
    int largest_step = 20;  // 1/16 px
};
inline constexpr SlopeReach kVoteSlopes{4, 20}, kSmoothingSlopes{5, 24};

Slopes find_slopes(const Disparities16& map, const SlopeReach& reach, ThreadPool& pool);

}  // namespace hexrelief
