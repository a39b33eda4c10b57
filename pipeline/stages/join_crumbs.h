// Crumbs: parts of a cut mesh that are too small to be things of their own.
#pragma once

#include <cstdint>
#include <vector>

#include "pipeline/data/disparity_mesh.h"

namespace hexrelief::stages {

// Joins connected components of fewer than 30 triangles to the larger one beside them, whichever costs least:
// the joined corners take its disparities, and the squares of what that changes are summed over the pixels.
// Components of at least least_px pixels join only if that costs at most 0.5 px2 a pixel of a lattice cell,
// which has cell_px pixels: a triangle on two surfaces that costs no more is not cut. Smaller ones join
// whatever it costs, and the rest of their corners take the mean of the joined corners' new disparities, a
// corner counted once for each end of a joined edge there. Triangles and points stay. The joined mesh may
// have vertices without triangles. Components with a vertex of `held` count as large. Copies of a vertex are
// adjacent to it.
void join_crumbs(DisparityMesh& mesh, double cell_px, double least_px = 0,
                 const std::vector<std::uint32_t>& held = {});

}  // namespace hexrelief::stages
