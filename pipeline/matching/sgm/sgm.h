// Semi-global matching of a pair (Hirschmueller 2008), on census and colour.
#pragma once

#include <cstddef>

#include "pipeline/base/thread_pool.h"
#include "pipeline/matching/common/bordered_raster.h"
#include "pipeline/matching/common/color_planes.h"
#include "pipeline/matching/sgm/path_step.h"
#include "pipeline/matching/sgm/paths.h"
#include "pipeline/matching/sgm/volume.h"

namespace hexrelief::matching {

// Returns the windows, from the left view's winners at half size (see step::find_window()). If the range is
// searched completely, all windows are kWholeWindow and `half` is not read.
SearchWindows find_windows(int width, int height, const DisparityRange& range, DisparityView half,
                           ThreadPool& pool);

// Sets rows first .. end - 1 of both views from the volume, which must contain them. The right view's
// costs are the left view's at the matching pixels: left(x, d) = right(x - d, d). A right pixel that no
// window matches is unknown.
void find_winners(const MatchingInput& input, const MatchingVolume& volume, int first, int end,
                  ViewDisparities& views, ThreadPool& pool);

// Bytes of the volume that the CPU holds at once; smaller than a cache shared by the cores.
inline constexpr std::size_t kBlock_bytes = std::size_t{32} << 20;

// Finds the winners of both views, band by band. range.count is 1..1920. The result does
// not depend on block_bytes.
ViewDisparities match_views(const ColorPlanes& left, const ColorPlanes& right, const DisparityRange& range,
                            WindowView windows, const step::PathPenalties& penalties, ThreadPool& pool,
                            std::size_t block_bytes = kBlock_bytes);

}  // namespace hexrelief::matching
