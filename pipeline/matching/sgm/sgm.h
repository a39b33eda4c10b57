// Semi-global matching of a pair (Hirschmueller 2008), on census and colour, in bands of rows if the cost
// volume exceeds kLargestVolume_bytes.
#pragma once

#include <cstddef>
#include <vector>

#include "pipeline/base/host_device.h"
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

// A picture whose volume, counted with kWholeRange disparities per pixel, exceeds this number of
// bytes is matched in bands of rows. Each band has kBandMargin more rows above and below, in which
// the vertical paths start.
inline constexpr std::size_t kLargestVolume_bytes = std::size_t{1980} << 20;
inline constexpr int kBandMargin = 64;

struct Rows {
    int first, end;
    HEXRELIEF_HD int count() const { return end - first; }
};
// A band: the rows that are matched, margins included, and those whose result is kept.
struct Band {
    Rows rows, kept;
};

// Returns the largest number of rows of a band, its margins included.
int band_rows(int width, int height);

// Returns the bands, top to bottom. CPU and CUDA use the same bands, so their results are identical.
std::vector<Band> bands_of(int width, int height);

}  // namespace hexrelief::matching
