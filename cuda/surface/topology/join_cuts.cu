#include "cuda/surface/topology/join_cuts.h"

#include "cuda/common/grid.cuh"

namespace hexrelief::cuda {
namespace {

__global__ void __launch_bounds__(kGridThreads, 1)
    join_cuts_kernel(const __grid_constant__ SurfaceState s, const __grid_constant__ step::CutArrays a) {
    if (s.totals->missing_capacity > 0) return;
    CooperativeGrid grid(s.board);
    const step::FanView view{s.lattice.triangles, s.lattice.neighbours, s.labels.open, s.labels.kept};
    step::CutJoiner(grid, view, a).join(s.counts->points, s.counts->triangles);
}

}  // namespace

void join_cuts(const Launch& launch, const SurfaceState& s, const step::CutArrays& a) {
    launch_cooperative(launch, join_cuts_kernel, 0, "joining cuts", s, a);
}

}  // namespace hexrelief::cuda
