// Semi-global matching of a pair (Hirschmueller 2008), on census and colour.
#pragma once

#include <cstddef>

#include "pipeline/base/thread_pool.h"
#include "pipeline/matching/common/color_planes.h"
#include "pipeline/matching/sgm/path_step.h"
#include "pipeline/matching/sgm/winners.h"

namespace hexrelief::matching {

// Bytes of the volume that the CPU holds at once; smaller than a cache shared by the cores.
inline constexpr std::size_t kBlock_bytes = std::size_t{32} << 20;

// Finds the winners of both views, band by band. range.count is 1..1920. The result does
// not depend on block_bytes.
ViewDisparities match_views(const ColorPlanes& left, const ColorPlanes& right, const DisparityRange& range,
                            WindowView windows, const step::PathPenalties& penalties, ThreadPool& pool,
                            std::size_t block_bytes = kBlock_bytes);

}  // namespace hexrelief::matching
