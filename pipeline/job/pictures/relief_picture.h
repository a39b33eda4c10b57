// Draws a shaded view of the surface from the side.
#pragma once

#include "pipeline/data/image.h"
#include "pipeline/data/surface_mesh.h"

namespace hexrelief::job {

// Returns a picture of about 1200 px on its longer side, seen from 20 degrees to the side and a little above;
// textured if `texture` is not null. Drawn by a small z-buffer rasteriser with 2 x 2 samples per pixel.
Image render_relief(const SurfaceMesh& mesh, const Image* texture);

}  // namespace hexrelief::job
