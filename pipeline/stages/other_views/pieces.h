// Pieces of a surface that stand alone.
#pragma once

#include <cstddef>

#include "pipeline/data/calibration.h"
#include "pipeline/data/surface_mesh.h"
#include "pipeline/stages/other_views/view_place.h"

namespace hexrelief::stages {

struct PieceStrips {
    std::size_t least;           // triangles: pieces of fewer are joined
    double reach_px;             // of the left view
    bool only_in_views = false;  // none leads beyond all views' frames, where others would see it
};

// Joins small pieces to the nearest others by strips of six triangles between two sides of their borders, at
// most reach_px apart and 3 px of disparity high. No camera sees a strip: it leads behind the surface, which
// must cover it in all views that show the place. It has the colours of its beginning, but for its last 2 px.
// Pieces from which no such strip leads stay alone. visible: all that the cameras see.
void join_pieces(SurfaceMesh& mesh, const VisibleSurface& visible, const Calibration& camera,
                 const PieceStrips& strips);

}  // namespace hexrelief::stages
