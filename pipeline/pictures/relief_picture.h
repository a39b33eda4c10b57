// A shaded view of the surface from the side.
#pragma once

#include "pipeline/data/image.h"
#include "pipeline/data/surface_mesh.h"

namespace hexrelief::pictures {

// About 1200 px wide (portrait shapes: 1200 px high), seen from 20 degrees to the side and a little above,
// textured where texture is not null. A small z-buffer rasteriser, 2 x 2 samples a pixel.
Image render_relief(const SurfaceMesh& mesh, const Image* texture);

}  // namespace hexrelief::pictures
