// The paths of semi-global matching: from the left, the right, above and below.
#pragma once

#include "mesher/common/thread_pool.h"
#include "pipeline/matching/common/color_planes.h"
#include "pipeline/matching/sgm/path_step.h"
#include "pipeline/matching/sgm/volume.h"

namespace hexrelief {

// Sets the volume's costs, and its sums to the sum of the four paths' costs. Both pictures have one size and
// as many channels.
void aggregate(const ColorPlanes& left, const ColorPlanes& right, const DisparityRange& range,
               const step::PathPenalties& penalties, MatchingVolume& volume, ThreadPool& pool);

}  // namespace hexrelief
