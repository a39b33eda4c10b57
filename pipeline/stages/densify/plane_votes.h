// Chooses each unknown pixel's disparity by votes of the planes around it.
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

struct VoteInput {
    const DisparityMap& sparse;
    const std::vector<PlaneAt>& planes;  // of its known pixels
    const NearestMeasurements& nearest;
    const std::vector<std::uint8_t>& filled;  // 1 = the pixel is to be filled
    const Image& left;                        // may be empty
    const SideInput& sides;
};

// Fills pixels by votes. The planes of the measurements nearest to the pixels of a window of 7x7 at strides
// of stride_px vote; nearer planes and more similar colours have more weight. Votes that differ by at most 1
// px belong to one surface. Of the two surfaces with the most weight, that on whose side the pixel lies wins
// (side_odds()), and its mean is taken, so that nothing is blended across a discontinuity. No vote leaves the
// range of the voting measurements.
DisparityMap take_votes(const VoteInput& input, int stride_px, ThreadPool& pool);

}  // namespace hexrelief::stages
