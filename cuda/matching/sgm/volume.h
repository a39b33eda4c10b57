// What semi-global matching keeps for each pixel and each disparity searched there, of some rows.
#pragma once

#include "cuda/matching/common/device_raster.h"
#include "cuda/matching/sgm/path_pixels.h"
#include "pipeline/matching/sgm/bands.h"

namespace hexrelief::cuda {

// A group of lanes holds a pixel's entries, each a part of the far run and the same part of the near one: in
// pairs of 16 bits, the far run's lower. So what lies beside one pair is another pair.
inline constexpr int kGroup = kRun / kPart, kLanePairs = kPart;
inline constexpr int kLaneEntries = 2 * kPart;

// kSearched entries a pixel of the band's rows: of costs, lane after lane; of sums, half of each lane's
// pairs, then the other halves, so that lanes together fill whole sectors of memory.
struct DeviceVolume {
    int width, count;  // of the range's disparities
    Band band;
    PathPixels pixels;  // of the whole picture
    std::uint8_t* costs;
    std::uint16_t *sums_of_rows, *sums_of_columns;  // of the costs of an axis's paths that end there

    // Where a pixel's entry lies among its sums.
    static HEXRELIEF_HD int place(int entry) {
        const int in_run = entry % kRun, lane = in_run / kPart, k = in_run % kPart;
        return (k / 4 * kGroup + lane) * 8 + k % 4 * 2 + entry / kRun;
    }
};

}  // namespace hexrelief::cuda
