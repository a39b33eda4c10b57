// Silhouettes at high depth discontinuities end inside of their own surfaces.
#pragma once

#include "cuda/common/launch.h"
#include "cuda/common/surface_state.h"
#include "cuda/surface/fit/fit_silhouettes.h"

namespace hexrelief::cuda {

// As surface::inset_silhouettes(): moves s.cut_mesh.points; the silhouettes' arrays serve here as well.
void inset_silhouettes(const Launch& launch, const SurfaceState& s, const SilhouetteFitArrays& a);

}  // namespace hexrelief::cuda
