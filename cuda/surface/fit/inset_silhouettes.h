// Insets silhouettes at high depth discontinuities into their own surfaces.
#pragma once

#include "cuda/common/launch.h"
#include "cuda/common/surface_state.h"
#include "mesher/surface/fit/disparity_fitter_step.h"
#include "mesher/surface/fit/inset_silhouettes_step.h"

namespace hexrelief::cuda {

// Returns arrays in the memory of the disparities' fit, which comes later.
inline step::InsetArrays inset_arrays(const step::FitArrays& fit) {
    return {fit.corners, reinterpret_cast<Vec2f*>(fit.values[0]),
            reinterpret_cast<std::uint8_t*>(fit.values[1])};
}

// Does the same as surface::inset_silhouettes(): moves s.cut_mesh.points.
void inset_silhouettes(const Launch& launch, const SurfaceState& s, const step::InsetArrays& a);

}  // namespace hexrelief::cuda
