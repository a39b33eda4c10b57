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

// A block of pixel_blocks() finds the sides of the blocks in it: each row's by eight lanes, then the rows'.
constexpr int kSide = step::kSidesBlock_px, kSidesInBlock = 32 / kSide;

__global__ void find_sides_kernel(matching::DisparityView map, BlockSides sides) {
    static_assert(kSide == 8);  // the height of a block of pixel_blocks()
    begin_kernel();
    const int2 at = pixel_of_thread();
    step::Sides own = step::no_sides();
    if (at.x < map.width && at.y < map.height) {
        const std::int16_t* const pixel = &map.at(at.x, at.y);
        if (step::beside_discontinuity(pixel, map.stride)) own = {*pixel, *pixel};
    }
    int farthest = own.farthest, nearest = own.nearest;
#pragma unroll
    for (int lanes = kSide / 2; lanes > 0; lanes /= 2) {
        farthest = min(farthest, __shfl_xor_sync(~0u, farthest, lanes));
        nearest = max(nearest, __shfl_xor_sync(~0u, nearest, lanes));
    }
    __shared__ step::Sides rows[kSide][kSidesInBlock];
    const int lane = static_cast<int>(threadIdx.x), row = static_cast<int>(threadIdx.y);
    if (lane % kSide == 0)
        rows[row][lane / kSide] = {static_cast<std::int16_t>(farthest), static_cast<std::int16_t>(nearest)};
    __syncthreads();
    const int column = static_cast<int>(blockIdx.x) * kSidesInBlock + lane;
    if (row > 0 || lane >= kSidesInBlock || column >= sides.width) return;
    step::Sides all = step::no_sides();
#pragma unroll
    for (int i = 0; i < kSide; ++i) all = step::both(all, rows[i][lane]);
    sides.at(column, static_cast<int>(blockIdx.y)) = all;
}

// How certain a pixel's disparity is.
__device__ step::Certainty certainty_of(const VoterInput& in, const BlockSides& sides, int x, int y) {
    step::Sides around = step::no_sides();
#pragma unroll
    for (int j = -1; j <= 1; ++j)
#pragma unroll
        for (int i = -1; i <= 1; ++i)
            around = step::both(
                around, sides.at(clamped(x / kSide + i, sides.width), clamped(y / kSide + j, sides.height)));
    if (around.nearest < 0) return step::Certainty::right;
    const step::RowSite site{x, in.map.width, in.min_px, in.nearest_seen.row(y)};
    return step::certainty(site, in.map.at(x, y), around,
                           PixelDifference{in.right.row(y), site, in.left.at(x, y)});
}

__global__ void weigh_voters_kernel(VoterInput in, matching::RasterView<const std::uint8_t> all_matched,
                                    BlockSides sides, PixelList holes,
                                    matching::RasterView<std::uint8_t> weights) {
    begin_kernel();
    const int2 at = pixel_of_thread();
    const bool inside = at.x < in.map.width && at.y < in.map.height;
    const bool matched = inside && all_matched.at(at.x, at.y),
               doubtful = matched && certainty_of(in, sides, at.x, at.y) != step::Certainty::right;
    add_to_list(holes, doubtful, at);
    if (!inside) return;
    std::uint8_t& weight = weights.at(at.x, at.y);
    weight = step::kMatchedWeight;
    if (matched && !doubtful) return;
    const int disparity = in.map.at(at.x, at.y);
    const step::RowSite site{at.x, in.map.width, in.min_px, in.nearest_seen.row(at.y)};
    weight = step::filled_weight(site, disparity, in.in_color, MatchDifference{in, at.x, at.y, disparity});
}

__global__ void weigh_later_voters_kernel(VoterInput in, BlockSides sides,
                                          matching::RasterView<PixelRecord> records) {
    begin_kernel();
    const int2 at = pixel_of_thread();
    if (at.x < in.map.width && at.y < in.map.height)
        records.at(at.x, at.y).vote_weight = step::later_weight(certainty_of(in, sides, at.x, at.y));
}

void find_sides(cudaStream_t stream, const matching::DisparityView& map, const BlockSides& sides) {
    launch("finding sides", stream, pixel_blocks(map.width, map.height), find_sides_kernel, map, sides);
}

}  // namespace

void blur_colors(cudaStream_t stream, const PackedColors& colors,
                 const matching::RasterView<std::uint32_t>& out) {
    launch("blurring colours", stream, pixel_blocks(colors.width, colors.height), blur_colors_kernel, colors,
           out);
}

BlockSides take_block_sides(Arena& arena, int width, int height) {
    return take_plain_raster<step::Sides>(arena, (width + kSide - 1) / kSide, (height + kSide - 1) / kSide);
}

void weigh_voters(cudaStream_t stream, const VoterInput& input,
                  const matching::RasterView<const std::uint8_t>& matched, const BlockSides& sides,
                  const PixelList& holes, const matching::RasterView<std::uint8_t>& weights) {
    find_sides(stream, input.map, sides);
    launch("weighing voters", stream, pixel_blocks(input.map.width, input.map.height), weigh_voters_kernel,
           input, matched, sides, holes, weights);
}

void weigh_later_voters(cudaStream_t stream, const VoterInput& input, const BlockSides& sides,
                        const matching::RasterView<PixelRecord>& records) {
    find_sides(stream, input.map, sides);
    launch("weighing voters", stream, pixel_blocks(input.map.width, input.map.height),
           weigh_later_voters_kernel, input, sides, records);
}

}  // namespace hexrelief::cuda
