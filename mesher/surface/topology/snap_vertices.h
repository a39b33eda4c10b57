// Moves lattice vertices onto silhouettes.
#pragma once

#include <cstdint>
#include <vector>

#include "mesher/surface/pixels/pixel_surfaces.h"
#include "mesher/surface/topology/snap_vertices_step.h"
#include "pipeline/base/thread_pool.h"
#include "pipeline/data/hex_mesh.h"

namespace hexrelief::surface {

// For each lattice edge that crosses a silhouette moves the nearer of its two vertices onto the silhouette,
// by up to kSnapReach of the edge, nearest first, unless a triangle would become thin or inverted. Border
// vertices slide along the image's border. part: the mesh's position in a larger one. Returns for each vertex
// whether it lies on a silhouette now.
std::vector<std::uint8_t> snap_to_silhouettes(const PixelSurfaces& surfaces, const step::LatticePart& part,
                                              HexMesh2D& mesh, ThreadPool& pool);

}  // namespace hexrelief::surface
