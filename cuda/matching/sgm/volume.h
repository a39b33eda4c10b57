// The data that semi-global matching keeps for each pixel and each disparity searched there, for
// a band of rows.
#pragma once

#include "cuda/matching/common/device_raster.h"
#include "cuda/matching/sgm/path_pixels.h"
#include "pipeline/matching/sgm/bands.h"

namespace hexrelief::cuda {

// A group of lanes holds a pixel's entries, each lane a part of the far run and the same part of the near
// run, in pairs of 16 bits with the far run's entry in the lower half. So the neighbours of a pair's entries
// are another pair. Kernels are templates of a run's length.
inline constexpr int kGroup = 4;
template <int kRun>
inline constexpr int kPart = kRun / kGroup;

// The best match of a pixel of the right view: the upper half of its step::winner_key, the disparity, and the
// distance of the winner from it in 1/16 px. Better matches are smaller.
using RightBest = std::uint32_t;
inline constexpr RightBest kNoRightBest = ~RightBest{0};

// The entries of each pixel in the band's rows. Costs are stored lane by lane; of the sums, first four of
// each lane's pairs, then the others, so that the lanes together fill whole memory sectors.
struct DeviceVolume {
    int width;
    matching::DisparityRange range;
    matching::Band band;
    PathPixels pixels;  // the whole picture's
    std::uint8_t* costs;
    std::uint16_t *sums_of_rows, *sums_of_columns;  // costs of the axis' paths that end at a pixel, summed
    RightBest* right_best;                          // null: only the left view is wanted

    // Returns the index of an entry among its pixel's sums.
    template <int kRun>
    static HEXRELIEF_HD int place(int entry) {
        const int in_run = entry % kRun, lane = in_run / kPart<kRun>, k = in_run % kPart<kRun>;
        return (k / 4 * kGroup + lane) * 8 + k % 4 * 2 + entry / kRun;
    }
};

}  // namespace hexrelief::cuda
