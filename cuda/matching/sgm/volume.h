// What semi-global matching keeps for each pixel and disparity of a band of rows.
#pragma once

#include "cuda/matching/common/device_raster.h"

namespace hexrelief::cuda {

struct Rows {
    int first, end;
    HEXRELIEF_HD int count() const { return end - first; }
};

// Disparities innermost, `pitch` entries a pixel, of which those from `count` on say nothing.
struct DeviceVolume {
    int width, count, pitch;
    Rows rows;  // of costs: the band with its margins, through which vertical paths come
    Rows kept;  // of sums
    std::uint8_t* costs;
    std::uint16_t* sums;  // of the costs of the paths that end there
};

}  // namespace hexrelief::cuda
