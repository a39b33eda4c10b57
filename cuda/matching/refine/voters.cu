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
    const auto is_filled = [&](int x, int y) {
        weights.at(x, y) = step::kMatchedWeight;
        return !in.matched.at(x, y);
    };
    share_work_of_block(in.map.width, in.map.height, is_filled, [&](int x, int y) {
        const int disparity = in.map.at(x, y);
        const step::RowSite site{x, in.map.width, in.min_px, in.nearest_seen.row(y)};
        weights.at(x, y) =
            step::filled_weight(site, disparity, in.in_color, MatchDifference{in, x, y, disparity});
    });
}

}  // namespace

void weigh_voters(cudaStream_t stream, const VoterInput& input, const RasterView<std::uint8_t>& weights) {
    weigh_voters_kernel<<<pixel_grid(input.map.width, input.map.height), pixel_block(), 0, stream>>>(input,
                                                                                                     weights);
    check_launch("weighing voters");
}

}  // namespace hexrelief::cuda
