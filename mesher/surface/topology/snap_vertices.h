// Moves lattice vertices onto the rims of surfaces.
#pragma once

#include <cstdint>
#include <vector>

#include "mesher/surface/pixels/discontinuities.h"
#include "mesher/common/thread_pool.h"
#include "pipeline/data/hex_mesh.h"

namespace hexrelief {

// Wherever a lattice edge crosses a rim, the nearer of its two vertices moves onto the rim, by at most about
// half an edge, nearest first; not where a triangle would become thin or inverted. Border vertices slide
// along the image's border. Returns for each vertex whether it lies on a rim now.
std::vector<std::uint8_t> align_to_rims(const PixelSurfaces& surfaces, HexMesh2D& mesh, Team& team);

}  // namespace hexrelief
