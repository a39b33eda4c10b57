// Decides whether two triangles lie on different surfaces if no pixel votes on their edge.
#pragma once

#include "cuda/common/surface_state.h"
#include "cuda/common/triangle_groups.cuh"
#include "mesher/surface/topology/label_triangles_step.h"

namespace hexrelief::cuda {

// True if their disparities differ enough for a discontinuity between them.
__device__ inline bool may_differ(const SurfaceState& s, unsigned a, unsigned b) {
    return step::may_differ(s.view(), s.labels.anchors[a], s.labels.anchors[b], s.totals->discontinuity_px);
}
// True if a discontinuity also lies between the triangles' anchors; by a group of lanes.
__device__ inline bool differ(const SurfaceState& s, const TriangleLanes& group, bool has, unsigned a,
                              unsigned b) {
    const step::PixelView view = s.view();
    has = has && may_differ(s, a, b);
    if (!__any_sync(kAllLanes, has)) return false;
    bool met = false;
    if (has) {
        const step::Way way = step::way_between_pixels(view, s.labels.anchors[a], s.labels.anchors[b]);
        step::Crack crack;
        HEXRELIEF_ROLLED
        for (int k = static_cast<int>(group.lane); k < way.steps; k += static_cast<int>(group.size))
            met |= step::steps_over(view, step::pixel_after(view, way, k),
                                    step::pixel_after(view, way, k + 1), crack);
    }
    return group.ballot(met) != 0;
}

}  // namespace hexrelief::cuda
