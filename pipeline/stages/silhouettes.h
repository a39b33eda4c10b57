// Moves the mesh's silhouettes to where the image shows them: the last step between the cut
// mesh and the surface.
#pragma once

#include "pipeline/data/disparity_map.h"
#include "pipeline/data/disparity_mesh.h"

namespace hexrelief::stages {

// Moves vertices on the mesh's borders if that lowers the error of the pixels around them; by at most 0.75 px
// each, in `rounds` passes over all of them (0 = not at all). Near surfaces weigh more, and a pixel farther
// than half a pixel from every triangle counts as 10 px off, as in SurfaceQuality. A moved vertex stays on
// the plane of its largest triangle, and no triangle turns over. Pixels that are unknown or below
// background_px do not count. The result depends on the arguments only.
void adjust_silhouettes(DisparityMesh& mesh, const DisparityMap& map, float background_px, int rounds);

}  // namespace hexrelief::stages
