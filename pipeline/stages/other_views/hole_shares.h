// Measures how much of a surface is open when it is seen from elsewhere.
#pragma once

#include "pipeline/data/disparity_map.h"
#include "pipeline/data/surface_mesh.h"

namespace hexrelief::stages {

// Shares of the left picture's field, as it lies in the view from there, in which no triangle covers half of
// a pixel. In each row (from above: column) the field reaches from the first to the last place that the left
// picture shows, by its map.
struct HoleShares {
    double right = 0;  // from the right camera
    double above = 0;  // from one baseline above the left camera
};

// Measures a surface by its image_points, disparities and triangles; nothing else of `mesh` is used. map: the
// left view's; its unknown pixels count as the farther one of the known ones beside them in their row. What
// has the disparity shift_px lies at the same place in both cameras' views. Both shares are 0 if no pixel is
// known. The same for any number of threads (>= 1).
HoleShares measure_holes(const SurfaceMesh& mesh, const DisparityMap& map, double shift_px, int threads);

}  // namespace hexrelief::stages
