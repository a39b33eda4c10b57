// Chooses each unknown pixel's disparity by votes of the planes around it.
#pragma once

#include "pipeline/base/thread_pool.h"
#include "pipeline/stages/densify/measurements.h"
#include "pipeline/stages/densify/side_odds.h"

namespace hexrelief::stages {

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
