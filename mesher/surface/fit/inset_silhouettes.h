// Insets silhouettes at high depth discontinuities into their own surfaces.
#pragma once

#include "mesher/surface/pixels/pixel_surfaces.h"
#include "mesher/surface/topology/cut_vertices.h"
#include "pipeline/base/thread_pool.h"
#include "pipeline/data/disparity_map.h"

namespace hexrelief::surface {

// Moves the copies of a vertex at a high depth discontinuity apart, by `by_px` each, into their own surfaces,
// unless that uncovered a pixel that is not next to a high step. (At a step down to the background there is
// only one copy.) fans: fans of the lattice that `cut` comes from.
void inset_silhouettes(const PixelSurfaces& surfaces, const DisparityMap& map, double by_px,
                       const LatticeFans& fans, CutTriangles& cut, ThreadPool& pool);

}  // namespace hexrelief::surface
