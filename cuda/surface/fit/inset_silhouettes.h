// Insets silhouettes at high depth discontinuities into their own surfaces.
#pragma once

#include "cuda/common/launch.h"
#include "cuda/common/surface_state.h"
#include "cuda/surface/fit/fit_silhouettes.h"

namespace hexrelief::cuda {

// Does the same as surface::inset_silhouettes(): moves s.cut_mesh.points. It uses the silhouettes' arrays.
void inset_silhouettes(const Launch& launch, const SurfaceState& s, const SilhouetteFitArrays& a);

}  // namespace hexrelief::cuda
