// On which side of a discontinuity a pixel lies.
#pragma once

#include "mesher/common/thread_pool.h"
#include "pipeline/densify/measurements.h"

namespace hexrelief::densify {

struct SideInput {
    const std::vector<PlaneAt>& planes;
    const NearestMeasurements& around;  // without colours
    Image smooth;                       // smoothed() left picture; empty = none
    int stride_px;
};

// The picture by 1 2 1 along rows and along columns, for a pixel on a discontinuity has a colour of its own.
Image smoothed(const Image& picture, ThreadPool& pool);

// By what factor the weight of the surface with disparity d[0] at a pixel counts more than that of the one
// with d[1]. A side has the less weight the farther from the pixel the middle of its measurements is, which
// keeps lines straight, and the less their most similar colour is alike. Those count that are nearest to the
// pixels of a window of 13x13 at half the stride.
float side_odds(int x, int y, const float (&d)[2], const SideInput& input);

}  // namespace hexrelief::densify
