// Finds the pixels near discontinuities whose side the colours do not confirm.
#pragma once

#include "pipeline/base/thread_pool.h"
#include "pipeline/matching/common/color_planes.h"
#include "pipeline/matching/refine/certainty_step.h"

namespace hexrelief::matching {

struct CertaintyInput {
    const Disparities16& map;
    const PairColors& colors;
    const Raster<std::int32_t>& nearest_seen;  // see TrustedMatches
    int min_px;
};
Raster<step::Certainty> find_certainty(const CertaintyInput& input, ThreadPool& pool);

}  // namespace hexrelief::matching
