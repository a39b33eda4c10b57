#include "cuda/matching/refine/voters.h"

#include "cuda/matching/refine/match_colors.cuh"
#include "pipeline/matching/refine/voter_step.h"

namespace hexrelief::cuda {
namespace {

struct MatchDifference {
    const VoterInput& in;
    int x, y, disparity;

    HEXRELIEF_HD int operator()() const {
        return window_difference(in.left, in.right, x, y, step::position_in_right(x, in.min_px, disparity));
    }
};

__global__ void weigh_voters_kernel(VoterInput in, RasterView<std::uint8_t> weights) {
    const int2 at = pixel_of_thread();
    if (at.x >= in.map.width || at.y >= in.map.height) return;
    std::uint8_t weight = step::kMatchedWeight;
    if (!in.matched.at(at.x, at.y)) {
        const int disparity = in.map.at(at.x, at.y);
        const step::RowSite site{at.x, in.map.width, in.min_px, in.nearest_seen.row(at.y)};
        weight =
            step::filled_weight(site, disparity, in.in_color, MatchDifference{in, at.x, at.y, disparity});
    }
    weights.at(at.x, at.y) = weight;
}

}  // namespace

void weigh_voters(cudaStream_t stream, const VoterInput& input, const RasterView<std::uint8_t>& weights) {
    weigh_voters_kernel<<<pixel_grid(input.map.width, input.map.height), pixel_block(), 0, stream>>>(input,
                                                                                                     weights);
    check_launch("weighing voters");
}

}  // namespace hexrelief::cuda
