#include "cuda/surface/pixels/pixel_surfaces.h"

#include <cfloat>

#include "cuda/common/grid.cuh"

namespace hexrelief::cuda {
namespace {

// Finds the totals' nearest and farthest disparity.
__device__ void find_disparity_range(const CooperativeGrid& grid, const SurfaceState& s) {
    float nearest = 0, farthest = FLT_MAX;
    for (unsigned i = grid.thread(); i < s.sizes.pixels(); i += grid.threads()) {
        const float d = s.pixels.disparity[i];
        nearest = step::max_of(nearest, d);
        if (d > 0) farthest = step::min_of(farthest, d);
    }
    nearest = most_of_lanes(nearest);
    farthest = least_of_lanes(farthest);
    if (grid.lane() == 0 && nearest > 0) {
        atomicMax(reinterpret_cast<unsigned*>(&s.totals->nearest_px), __float_as_uint(nearest));
        atomicMin(reinterpret_cast<unsigned*>(&s.totals->farthest_px), __float_as_uint(farthest));
    }
}

__global__ void __launch_bounds__(kGridThreads, 1)
    find_pixel_surfaces_kernel(const __grid_constant__ SurfaceState s,
                               const __grid_constant__ step::PixelArrays arrays,
                               const __grid_constant__ step::PixelRules rules) {
    CooperativeGrid grid(s.board);
    if (grid.is_first()) {
        *s.totals = {};
        s.totals->nearest_px = s.nearest_px;
        s.totals->farthest_px = s.farthest_px;
        s.totals->discontinuity_px = rules.discontinuity_px;
    }
    step::find_pixel_surfaces(grid, arrays, rules);
    find_disparity_range(grid, s);
}

}  // namespace

void find_pixel_surfaces(const Launch& launch, const SurfaceState& s, step::PixelArrays arrays) {
    arrays.width = s.sizes.width;
    arrays.height = s.sizes.height;
    arrays.map = s.pixels.map;
    arrays.disparity = s.pixels.disparity;
    arrays.flags = s.pixels.flags;
    arrays.tile_sums = s.pixels.tile_sums;
    launch_cooperative(launch, find_pixel_surfaces_kernel, 0, "finding discontinuities", s, arrays,
                       step::pixel_rules(s.config, s.background_px, s.cell_px));
}

}  // namespace hexrelief::cuda
