#include "cuda/surface/fit/inset_silhouettes.h"

#include "cuda/common/grid.cuh"
#include "cuda/common/grid_scan.cuh"

namespace hexrelief::cuda {
namespace {

__global__ void __launch_bounds__(kGridThreads, 1)
    inset_silhouettes_kernel(const __grid_constant__ SurfaceState s,
                             const __grid_constant__ step::InsetArrays a) {
    if (s.totals->missing_capacity > 0) return;
    CooperativeGrid grid(s.board);
    const step::FanView<const std::int32_t(*)[3], const std::uint8_t(*)[3]> fans{
        s.lattice.triangles, s.lattice.neighbours, s.labels.open, s.labels.kept};
    step::inset_silhouettes(grid, s.view(), s.pixels.map, s.config.silhouette_inset_px, fans,
                            s.mesh_triangles(), s.cut_mesh.points, a);
}

}  // namespace

void inset_silhouettes(const Launch& launch, const SurfaceState& s, const step::InsetArrays& a) {
    launch_cooperative(launch, inset_silhouettes_kernel, 0, "insetting silhouettes", s, a);
}

}  // namespace hexrelief::cuda
