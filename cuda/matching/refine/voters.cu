#include "cuda/matching/refine/voters.h"

#include "cuda/matching/common/pixel_list.cuh"
#include "cuda/matching/refine/match_colors.cuh"
#include "pipeline/matching/refine/voter_step.h"

namespace hexrelief::cuda {
namespace {

// The colour difference of a pixel's window and the one at its disparity.
struct MatchDifference {
    const VoterInput& in;
    int x, y, disparity;

    HEXRELIEF_HD int operator()() const {
        return window_difference(in.left, in.right, x, y, step::position_in_right(x, in.min_px, disparity));
    }
};

// Returns the mean of 3x3 pixels, channel by channel.
__device__ std::uint32_t blurred(const PackedColors& colors, int x, int y) {
    std::uint16_t sums[3] = {};
#pragma unroll
    for (int j = -1; j <= 1; ++j) {
        const std::uint32_t* const row = colors.row(clamped(y + j, colors.height));
#pragma unroll
        for (int i = -1; i <= 1; ++i) {
            const std::uint32_t color = row[clamped(x + i, colors.width)];
#pragma unroll
            for (int c = 0; c < 3; ++c) sums[c] = static_cast<std::uint16_t>(sums[c] + channel_of(color, c));
        }
    }
    std::uint32_t color = 0;
#pragma unroll
    for (int c = 0; c < 3; ++c) color |= std::uint32_t{step::rounded_ninth(sums[c])} << (8 * c);
    return color;
}

__global__ void blur_colors_kernel(PackedColors colors, matching::RasterView<std::uint32_t> out) {
    begin_kernel();
    const int2 at = pixel_of_thread();
    if (at.x < colors.width && at.y < colors.height) out.at(at.x, at.y) = blurred(colors, at.x, at.y);
}

__global__ void weigh_voters_kernel(VoterInput in, matching::RasterView<std::uint8_t> weights) {
    begin_kernel();
    for_each_listed(in.holes, [&](int x, int y) {
        const int disparity = in.map.at(x, y);
        const step::RowSite site{x, in.map.width, in.min_px, in.nearest_seen.row(y)};
        weights.at(x, y) =
            step::filled_weight(site, disparity, in.in_color, MatchDifference{in, x, y, disparity});
    });
}

}  // namespace

void blur_colors(cudaStream_t stream, const PackedColors& colors,
                 const matching::RasterView<std::uint32_t>& out) {
    launch("blurring colours", stream, pixel_blocks(colors.width, colors.height), blur_colors_kernel, colors,
           out);
}

void weigh_voters(cudaStream_t stream, const VoterInput& input,
                  const matching::RasterView<std::uint8_t>& weights) {
    launch("weighing voters", stream, list_blocks(input.map.width, input.map.height), weigh_voters_kernel,
           input, weights);
}

}  // namespace hexrelief::cuda
