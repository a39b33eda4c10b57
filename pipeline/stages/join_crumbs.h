// Crumbs: parts of a cut mesh that are too small to be things of their own.
#pragma once

#include "pipeline/data/disparity_mesh.h"

namespace hexrelief::stages {

// Joins connected components of fewer than 30 triangles to the larger one beside them, whichever costs least,
// if that costs no more than most_px2: the joined corners take the disparities of the larger one, and the
// squares of what that changes are summed over the pixels. Triangles and points stay. The joined mesh may
// have vertices without triangles.
void join_crumbs(DisparityMesh& mesh, double most_px2);

}  // namespace hexrelief::stages
