// Moves lattice vertices onto the silhouettes of surfaces.
#pragma once

#include <cstdint>
#include <vector>

#include "mesher/common/thread_pool.h"
#include "mesher/surface/pixels/discontinuities.h"
#include "mesher/surface/topology/snap_vertices_step.h"
#include "pipeline/data/hex_mesh.h"

namespace hexrelief::surface {

// Wherever a lattice edge crosses a silhouette, the nearer of its two vertices moves onto the silhouette, by
// at most about half an edge, nearest first; not where a triangle would become thin or inverted. Border
// vertices slide along the image's border. part: where the mesh lies in a larger one. Returns for each
// vertex whether it lies on a silhouette now.
std::vector<std::uint8_t> snap_to_silhouettes(const PixelSurfaces& surfaces, const step::LatticePart& part,
                                              HexMesh2D& mesh, ThreadPool& pool);

}  // namespace hexrelief::surface
