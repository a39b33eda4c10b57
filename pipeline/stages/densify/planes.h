// Fits planes to the surfaces at the measurements.
#pragma once

#include <vector>

#include "pipeline/base/thread_pool.h"
#include "pipeline/stages/densify/measurements.h"

namespace hexrelief::stages {

// Sets the slopes of each plane to those that most measurements around it agree on. These are the
// measurements nearest to the pixels of a window of 7x7 at strides of stride_px. Those on other
// surfaces do not count.
void fit_planes(std::vector<PlaneAt>& planes, const NearestMeasurements& nearest, int stride_px,
                ThreadPool& pool);

}  // namespace hexrelief::stages
