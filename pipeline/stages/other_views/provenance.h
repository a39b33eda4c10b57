// Which cameras saw each vertex of a surface.
#pragma once

#include <vector>

#include "pipeline/data/surface_mesh.h"
#include "pipeline/stages/other_views/view_place.h"

namespace hexrelief::stages {

// Returns the provenance of each vertex of a surface with all its parts. The left view's part was seen by the
// left camera. A camera saw a vertex if in its view the surface at the vertex's pixel, or at one beside it,
// is at most 1 px of disparity in front of the vertex. seen: by the left camera and, if there was one, by the
// right camera; parts that no camera saw may be left out there. The same for any number of threads.
std::vector<Provenance> provenance_of(const SurfaceMesh& mesh, const std::vector<SeenSurface>& seen,
                                      int threads);

}  // namespace hexrelief::stages
