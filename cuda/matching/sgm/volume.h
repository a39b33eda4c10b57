// What semi-global matching keeps for each pixel and each disparity searched there, of some rows.
#pragma once

#include "cuda/matching/common/device_raster.h"
#include "pipeline/matching/sgm/bands.h"
#include "pipeline/matching/sgm/volume.h"

namespace hexrelief::cuda {

// A group of lanes holds a pixel's entries, each kLaneEntries of them that follow each other: in pairs, of
// which one is half of that farther than the other. So what lies beside one pair is another pair.
inline constexpr int kLaneEntries = 8, kLanePairs = kLaneEntries / 2;
inline constexpr int kGroup = kSearched / kLaneEntries, kRunLanes = kRun / kLaneEntries;

// All arrays: kSearched entries a pixel of the band's rows, as lanes hold them.
struct DeviceVolume {
    int width, count;  // of the range's disparities
    Band band;
    RasterView<const SearchWindow> windows;  // of the whole picture
    std::uint8_t* costs;
    std::uint16_t *sums_of_rows, *sums_of_columns;  // of the costs of an axis's paths that end there
    std::uint16_t* sums;                            // of both, where those of rows were

    // Where a pixel's entry lies among its entries.
    static HEXRELIEF_HD int place(int entry) {
        const int k = entry % kLaneEntries;
        return entry - k + k % kLanePairs * 2 + k / kLanePairs;
    }
};

}  // namespace hexrelief::cuda
