// Each unknown pixel's disparity by the planes around it.
#pragma once

#include "mesher/common/thread_pool.h"
#include "pipeline/densify/measurements.h"
#include "pipeline/densify/side_odds.h"

namespace hexrelief::densify {

struct VoteInput {
    const DisparityMap& sparse;
    const std::vector<PlaneAt>& planes;  // of its known pixels
    const NearestMeasurements& nearest;
    const std::vector<std::uint8_t>& filled;  // 1 = the pixel is to be known
    const Image& left;                        // empty = none
    const SideInput& sides;
};

// The planes of the measurements nearest to the pixels of a window of 7x7 at strides of stride_px vote, with
// the more weight the nearer they are and the more the colours are alike. Votes that differ by at most 1 px
// are of one surface; of the two heaviest the one on whose side the pixel lies holds (side_odds()), and its
// mean is taken, so that nothing is blended across a discontinuity. No vote leaves the range of the
// measurements that vote.
DisparityMap take_votes(const VoteInput& input, int stride_px, ThreadPool& pool);

}  // namespace hexrelief::densify
