// From both views' disparities to a map that is dense, smooth on surfaces and sharp between them.
#pragma once

#include "pipeline/matching/common/color_planes.h"
#include "pipeline/matching/refine/consistency.h"

namespace hexrelief {

struct RefinedMap {
    Disparities16 disparities;        // unknown only where nothing matched, there or in eight directions
    Raster<std::uint8_t> is_matched;  // 1 where the pixel was matched, 0 where it was filled
};

// 1 where the disparity is known.
Raster<std::uint8_t> known_pixels(const Disparities16& map, ThreadPool& pool);

RefinedMap refine(const ColorPlanes& left, const ViewDisparities& views, const ConsistencyConfig& config,
                  ThreadPool& pool);

}  // namespace hexrelief
