// Decides which edges of triangles are open.
#pragma once

#include "cuda/common/launch.h"
#include "cuda/common/surface_state.h"
#include "cuda/surface/topology/label_triangles.h"

namespace hexrelief::cuda {

// Does the same as TriangleLabeler::open_edges(): writes s.labels.open. To be called after label_triangles().
void open_edges(const Launch& launch, const SurfaceState& s, const LabelArrays& a);

}  // namespace hexrelief::cuda
