// Decides on which side of a discontinuity a pixel lies.
#pragma once

#include "pipeline/base/thread_pool.h"
#include "pipeline/stages/densify/measurements.h"

namespace hexrelief::stages {

struct SideInput {
    const std::vector<PlaneAt>& planes;
    const NearestMeasurements& around;  // without colours
    Image smooth;                       // smoothed() left picture; may be empty
    int stride_px;
};

// Returns the picture smoothed by 1 2 1 along rows and columns, because a pixel on a discontinuity has a
// colour of its own.
Image smoothed(const Image& picture, ThreadPool& pool);

// Returns the factor by which the weight of the surface with disparity d[0] at a pixel is multiplied
// before it is compared with that of the surface with d[1]. The factor is lower for a side the middle of
// whose measurements is farther from the pixel, which keeps lines straight, and for a side whose most
// similar colour is less similar. The measurements are those nearest to the pixels of a window of 13x13
// at half the stride.
float side_odds(int x, int y, const float (&d)[2], const SideInput& input);

}  // namespace hexrelief::stages
