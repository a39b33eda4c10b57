// Semi-global matching of a pair (Hirschmueller 2008), on census and colour.
#pragma once

#include <cstddef>

#include "mesher/common/thread_pool.h"
#include "pipeline/matching/common/color_planes.h"
#include "pipeline/matching/sgm/path_step.h"
#include "pipeline/matching/sgm/winners.h"

namespace hexrelief::matching {

// The volume that the CPU keeps at once, in bytes; smaller than a cache shared by the cores.
inline constexpr std::size_t kBlock_bytes = std::size_t{32} << 20;

// Winners of both views, band by band. range.count: 1..1920. block_bytes changes no bit of them.
ViewDisparities match_views(const ColorPlanes& left, const ColorPlanes& right, const DisparityRange& range,
                            WindowView windows, const step::PathPenalties& penalties, ThreadPool& pool,
                            std::size_t block_bytes = kBlock_bytes);

}  // namespace hexrelief::matching
