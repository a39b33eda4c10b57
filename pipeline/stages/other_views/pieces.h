// Pieces of a surface that stand alone.
#pragma once

#include <cstddef>

#include "pipeline/data/calibration.h"
#include "pipeline/data/surface_mesh.h"
#include "pipeline/stages/other_views/view_place.h"

namespace hexrelief::stages {

// Joins pieces of fewer than `least` triangles to the nearest others by strips of six triangles between two
// sides of their borders, at most reach_px apart in the left view and 3 px of disparity high. No camera sees
// a strip: it leads behind the surface, which must cover it in all views that show the place. It has the
// colours of its beginning, but for its last 2 px. Pieces from which no such strip leads stay alone.
// visible: all that the cameras see.
void join_pieces(SurfaceMesh& mesh, const VisibleSurface& visible, const Calibration& camera,
                 std::size_t least, double reach_px);

}  // namespace hexrelief::stages
