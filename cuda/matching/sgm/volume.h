// What semi-global matching keeps for each pixel and each disparity searched there, of some rows.
#pragma once

#include "cuda/matching/common/device_raster.h"
#include "cuda/matching/sgm/path_pixels.h"
#include "pipeline/matching/sgm/bands.h"

namespace hexrelief::cuda {

// A group of lanes holds a pixel's entries, each a part of the far run and the same part of the near one: in
// pairs of 16 bits, the far run's lower. So what lies beside one pair is another pair. Kernels are templates
// of a run's length.
inline constexpr int kGroup = 4;
template <int kRun>
inline constexpr int kPart = kRun / kGroup;

// The best match of a pixel of the right view: the upper half of its step::winner_key, the disparity, and how
// far from it the winner is, in 1/16 px. Better ones are less.
using RightBest = std::uint32_t;
inline constexpr RightBest kNoRightBest = ~RightBest{0};

// The entries of each pixel of the band's rows: of costs, lane after lane; of sums, four of each lane's
// pairs, then its other ones, so that lanes together fill whole sectors of memory.
struct DeviceVolume {
    int width;
    matching::DisparityRange range;
    matching::Band band;
    PathPixels pixels;  // of the whole picture
    std::uint8_t* costs;
    std::uint16_t *sums_of_rows, *sums_of_columns;  // of the costs of an axis's paths that end there
    RightBest* right_best;                          // null: only the left view is wanted

    // Where a pixel's entry lies among its sums.
    template <int kRun>
    static HEXRELIEF_HD int place(int entry) {
        const int in_run = entry % kRun, lane = in_run / kPart<kRun>, k = in_run % kPart<kRun>;
        return (k / 4 * kGroup + lane) * 8 + k % 4 * 2 + entry / kRun;
    }
};

}  // namespace hexrelief::cuda
