// Removes small triangles that span a step which their surface does not have.
#pragma once

#include "mesher/common/thread_pool.h"
#include "pipeline/data/disparity_mesh.h"

namespace hexrelief {

// Removes the slivers, see step::is_sliver(), and the vertices that nothing then uses. Before, every vertex
// holds one fan; those of slivers may be non-manifold after, and are listed in `non_manifold`.
void remove_slivers(DisparityMesh& cut_mesh, double discontinuity_px, ThreadPool& pool);

}  // namespace hexrelief
