// What semi-global matching keeps for each pixel and disparity of some rows.
#pragma once

#include "cuda/matching/common/device_raster.h"

namespace hexrelief::cuda {

struct Rows {
    int first, end;
    HEXRELIEF_HD int count() const { return end - first; }
};

// Of a picture that is matched in bands: `rows` holds `kept` and the margins, from which vertical paths
// start.
struct Band {
    Rows rows, kept;
};

// Disparities innermost, `pitch` entries a pixel, of which those from `count` on say nothing.
struct DeviceVolume {
    int width, count, pitch;
    Band band;  // costs of all its rows, sums of those kept; several bands that follow each other
    std::uint8_t* costs;
    std::uint16_t* sums;  // of the costs of the paths that end there
};

}  // namespace hexrelief::cuda
