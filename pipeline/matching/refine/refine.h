// From both views' disparities to a map that is dense, smooth on surfaces and sharp between them.
#pragma once

#include "mesher/common/thread_pool.h"
#include "pipeline/matching/common/color_planes.h"
#include "pipeline/matching/refine/consistency.h"
#include "pipeline/matching/refine/frame_segments.h"
#include "pipeline/matching/refine/half_size_matches.h"

namespace hexrelief::matching {

struct RefinedMap {
    Disparities16 disparities;        // unknown only where nothing matched, there or in eight directions
    Raster<std::uint8_t> is_matched;  // 1 where the pixel was matched, 0 where it was filled
};

// 1 where the disparity is known.
Raster<std::uint8_t> known_pixels(const Disparities16& map, ThreadPool& pool);

struct RefineInput {
    const FrameSegments& frame_segments;  // of the left picture
    const PairColors& colors;
    const ViewDisparities& views;
    // Null, or more matches, where the views have none; they count as filled.
    const HalfSizeMatches* half_size;
};
RefinedMap refine(const RefineInput& input, const ConsistencyConfig& config, ThreadPool& pool);

}  // namespace hexrelief::matching
