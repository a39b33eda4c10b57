// Silhouettes moved to where the image shows them: the last step between the cut mesh and the surface.
#pragma once

#include "pipeline/data/disparity_map.h"
#include "pipeline/data/disparity_mesh.h"

namespace hexrelief::stages {

// Moves vertices on the mesh's borders, by at most 0.75 px and `rounds` times around (0 = not at all), where
// that lowers the error of the pixels around them: near surfaces count more, and a pixel that no triangle
// comes within half a pixel of counts as 10 px off, as in SurfaceQuality. A moved vertex stays on the plane
// of its largest triangle, and no triangle turns over. Pixels that are unknown or below background_px do not
// count. The result depends on the arguments alone.
void adjust_silhouettes(DisparityMesh& mesh, const DisparityMap& map, float background_px, int rounds);

}  // namespace hexrelief::stages
