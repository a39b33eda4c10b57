// How much a pixel counts in the fit of the disparities.
#pragma once

#include "mesher/common/host_device.h"
#include "mesher/common/surface_thresholds_step.h"
#include "mesher/surface/fit/fit_disparities_step.h"

namespace hexrelief::step {

// The weight of a pixel whose disparity the initial surface misses by `residual` px. Pixels behind a low
// half-occlusion step count in full: there the initial surface is what may be wrong.
HEXRELIEF_HD double fit_weight(double residual, bool behind_low_half_occlusion) {
    return behind_low_half_occlusion ? kHalfOcclusionWeight : huber_weight(residual, kFitTolerance_px);
}

}  // namespace hexrelief::step
