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

// Disparities innermost, `pitch` entries a pixel, in an order of their own: a lane of a path has `lane_count`
// that follow each other, in pairs of which one is half of that farther than the other. So what lies beside
// one pair is another pair. Where count is less than pitch, some entries say nothing.
struct DeviceVolume {
    int width, count, pitch;
    int lane_count;
    Band band;  // costs of all its rows, sums of those kept; several bands that follow each other
    std::uint8_t* costs;
    std::uint16_t* sums;  // of the costs of the paths that end there

    // Of a pixel's entries the one of this disparity.
    HEXRELIEF_HD int entry(int disparity) const {
        const int half = lane_count / 2, k = disparity % lane_count;
        return disparity - k + k % half * 2 + k / half;
    }
};

}  // namespace hexrelief::cuda
