// Turns both views' disparities into one map that is dense, smooth on surfaces and sharp between them.
#pragma once

#include "pipeline/base/thread_pool.h"
#include "pipeline/matching/common/color_planes.h"
#include "pipeline/matching/refine/consistency.h"
#include "pipeline/matching/refine/fill.h"
#include "pipeline/matching/refine/frame_segments.h"

namespace hexrelief::matching {

struct RefinedMap {
    Disparities16 disparities;        // unknown only if neither the pixel nor any in eight directions matched
    Raster<std::uint8_t> is_matched;  // 1 = matched, 0 = filled
};

// Returns 1 for each known disparity, else 0.
Raster<std::uint8_t> known_pixels(const Disparities16& map, ThreadPool& pool);

struct RefineInput {
    const FrameSegments& frame_segments;  // the left picture's
    const PairColors& colors;
    const ViewDisparities& views;
    // Optional extra matches from half size, used for pixels that are unknown in `views` and marked as
    // filled. May be null.
    const HalfSizeMatches* half_size;
};
// Returns the left view's map.
RefinedMap refine(const RefineInput& input, const ConsistencyConfig& config, ThreadPool& pool);

}  // namespace hexrelief::matching
