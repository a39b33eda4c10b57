// Takes slivers from the mesh, as mesher/remove_slivers.cpp does.
#pragma once

#include "cuda/common/grid.cuh"
#include "cuda/common/surface_state.cuh"
#include "mesher/surface/fit/remove_slivers_step.h"

namespace hexrelief::cuda {

struct SliverArrays {
    std::uint8_t *slivers, *used;  // of triangles; of vertices
    unsigned* places;              // of vertices, and of the first triangle behind them
    Vec2f* points;                 // as they will be,
    float* disparities;
    Triangle* triangles;  // in the same row of places as the vertices
};

template <typename Take>
SliverArrays take_sliver_arrays(const SurfaceSizes& sizes, const Take& take) {
    const std::size_t points = sizes.most_points, triangles = sizes.most_triangles;
    SliverArrays a{};
    a.slivers = take.template operator()<std::uint8_t>(triangles);
    a.used = take.template operator()<std::uint8_t>(points);
    a.places = take.template operator()<unsigned>(points + 1);
    a.points = take.template operator()<Vec2f>(points);
    a.disparities = take.template operator()<float>(points);
    a.triangles = take.template operator()<Triangle>(points + triangles);
    return a;
}

// After fit_disparities(), where the mesh is cut and not bridged: takes the slivers from s.mesh's points,
// disparities and triangles, and from the totals.
template <typename CooperativeGrid>
__device__ void remove_slivers(CooperativeGrid& grid, const SurfaceState& s, const SliverArrays& a) {
    const unsigned points = s.totals->mesh_points, triangles = s.totals->mesh_triangles;
    const CutMesh& cut_mesh = s.cut_mesh;
    bool mine = false;
    for (unsigned t = grid.thread(); t < triangles; t += grid.threads()) {
        const Triangle v = cut_mesh.triangles[t];
        a.slivers[t] = step::is_sliver(cut_mesh.points[v[0]], cut_mesh.points[v[1]], cut_mesh.points[v[2]],
                                       cut_mesh.disparities[v[0]], cut_mesh.disparities[v[1]],
                                       cut_mesh.disparities[v[2]], s.totals->discontinuity_px);
        mine |= a.slivers[t] != 0;
    }
    for (unsigned v = grid.thread(); v < points; v += grid.threads()) a.used[v] = 0;
    if (!grid.any(mine)) return;
    grid.each(triangles, [&](unsigned t) {
        if (a.slivers[t] == 0)
            for (const unsigned v : cut_mesh.triangles[t]) a.used[v] = 1;
    });
    // Vertices and triangles are counted in one row.
    const unsigned all = grid.scan(
        points + triangles,
        [&](unsigned i) -> unsigned { return i < points ? a.used[i] : a.slivers[i - points] == 0; },
        [&](unsigned i, unsigned before) {
            if (i <= points) a.places[i] = before;
            if (i >= points) {
                if (a.slivers[i - points] == 0) a.triangles[before] = cut_mesh.triangles[i - points];
            } else if (a.used[i] != 0) {
                a.points[before] = cut_mesh.points[i];
                a.disparities[before] = cut_mesh.disparities[i];
            }
        });
    const unsigned used = a.places[points];
    if (grid.thread() == 0) {
        s.totals->mesh_points = used;
        s.totals->mesh_triangles = all - used;
    }
    grid.each(all, [&](unsigned i) {
        if (i < used) {
            cut_mesh.points[i] = a.points[i];
            cut_mesh.disparities[i] = a.disparities[i];
        } else {
            const Triangle v = a.triangles[i];
            cut_mesh.triangles[i - used] = {a.places[v[0]], a.places[v[1]], a.places[v[2]]};
        }
    });
}

}  // namespace hexrelief::cuda
