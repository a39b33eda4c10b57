#include "cuda/matching/refine/match_colors.cuh"
#include "cuda/matching/refine/sides.h"
#include "pipeline/matching/refine/side_step.h"

namespace hexrelief::cuda {
namespace {

__global__ void choose_sides_kernel(SideInput in, matching::DisparityOut chosen) {
    begin_kernel();
    const int2 at = pixel_of_thread();
    if (at.x >= in.map.width || at.y >= in.map.height) return;
    const std::int16_t* const pixel = &in.map.at(at.x, at.y);
    const std::int16_t own = *pixel;
    const step::Sides sides = step::sides_at(pixel, in.map.stride);
    std::int16_t best = own;
    if (step::discontinuous(own, sides.farthest) || step::discontinuous(own, sides.nearest)) {
        const step::RowSite site{at.x, in.map.width, in.min_px, in.nearest_seen.row(at.y)};
        best = step::better_side(site, own, sides,
                                 PixelDifference{in.right.row(at.y), site, in.left.at(at.x, at.y)});
    }
    chosen.at(at.x, at.y) = best;
}

}  // namespace

void choose_sides(cudaStream_t stream, const SideInput& input, const matching::DisparityOut& chosen) {
    launch("choosing sides", stream, pixel_blocks(input.map.width, input.map.height), choose_sides_kernel,
           input, chosen);
}

}  // namespace hexrelief::cuda
