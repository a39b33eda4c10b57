// Least-squares fit of the vertices' disparities to the triangles' own pixels.
#pragma once

#include <vector>

#include "mesher/common/thread_pool.h"
#include "mesher/surface/pixels/discontinuities.h"
#include "mesher/surface/topology/cut_vertices.h"
#include "mesher/surface/topology/label_triangles.h"

namespace hexrelief::surface {

// Disparities of the vertices, px, above 0. labels: of the lattice that `cut` comes from, with `fitted`.
// farthest_px: a disparity that counts as one of the map's; 0 = none.
std::vector<float> fit_disparities(const PixelSurfaces& surfaces, const TriangleLabels& labels,
                                   const CutTriangles& cut, float farthest_px, ThreadPool& pool);

}  // namespace hexrelief::surface
