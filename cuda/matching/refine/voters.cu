#include "cuda/matching/refine/voters.h"

#include "cuda/matching/common/pixel_list.cuh"
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
    begin_kernel();
    for_each_listed(in.holes, [&](int x, int y) {
        const int disparity = in.map.at(x, y);
        const step::RowSite site{x, in.map.width, in.min_px, in.nearest_seen.row(y)};
        weights.at(x, y) =
            step::filled_weight(site, disparity, in.in_color, MatchDifference{in, x, y, disparity});
    });
}

}  // namespace

void weigh_voters(cudaStream_t stream, const VoterInput& input, const RasterView<std::uint8_t>& weights) {
    launch("weighing voters", stream, list_blocks(input.map.width, input.map.height), weigh_voters_kernel,
           input, weights);
}

}  // namespace hexrelief::cuda
