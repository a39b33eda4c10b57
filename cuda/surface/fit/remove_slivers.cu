#include "cuda/surface/fit/remove_slivers.h"

#include "cuda/common/grid.cuh"
#include "cuda/common/grid_scan.cuh"
#include "mesher/surface/fit/remove_slivers_step.h"

namespace hexrelief::cuda {
namespace {

// After fit_disparities(), where the mesh is cut and not bridged: takes the slivers from s.mesh's points,
// disparities and triangles, and from the totals.
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
    const unsigned all = exclusive_scan(
        grid, points + triangles,
        [&](unsigned i) -> unsigned { return i < points ? a.used[i] : a.slivers[i - points] == 0; },
        [&](unsigned i, unsigned before) {
            if (i <= points) a.indices[i] = before;
            if (i >= points) {
                if (a.slivers[i - points] == 0) a.triangles[before] = cut_mesh.triangles[i - points];
            } else if (a.used[i] != 0) {
                a.points[before] = cut_mesh.points[i];
                a.disparities[before] = cut_mesh.disparities[i];
            }
        });
    const unsigned used = a.indices[points];
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
            cut_mesh.triangles[i - used] = {a.indices[v[0]], a.indices[v[1]], a.indices[v[2]]};
        }
    });
}

__global__ void __launch_bounds__(kGridThreads, 1)
    remove_slivers_kernel(const __grid_constant__ SurfaceState s, const __grid_constant__ SliverArrays a) {
    if (s.totals->missing_capacity > 0) return;
    CooperativeGrid grid(s.board);
    remove_slivers(grid, s, a);
}

}  // namespace

void remove_slivers(const Launch& launch, const SurfaceState& s, const SliverArrays& a) {
    launch_cooperative(launch, remove_slivers_kernel, 0, "removing slivers", s, a);
}

}  // namespace hexrelief::cuda
