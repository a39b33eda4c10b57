// Fits the vertices' disparities to the triangles' own pixels by least squares.
#pragma once

#include <vector>

#include "mesher/surface/pixels/pixel_surfaces.h"
#include "mesher/surface/topology/cut_vertices.h"
#include "mesher/surface/topology/label_triangles.h"
#include "pipeline/base/thread_pool.h"

namespace hexrelief::surface {

// Returns the disparities of the vertices, px, above 0. labels: labels of the lattice that `cut` comes from,
// with `fitted`. farthest_px: smallest disparity of the whole map, if the map is a part of it; 0 = none.
std::vector<float> fit_disparities(const PixelSurfaces& surfaces, const TriangleLabels& labels,
                                   const CutTriangles& cut, float farthest_px, ThreadPool& pool);

}  // namespace hexrelief::surface
