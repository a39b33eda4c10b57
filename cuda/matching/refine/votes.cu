#include <algorithm>

#include "cuda/common/warp_reduce.cuh"
#include "cuda/matching/common/pixels.cuh"
#include "cuda/matching/refine/record_access.cuh"
#include "cuda/matching/refine/votes.h"
#include "pipeline/matching/refine/vote_step.h"

namespace hexrelief::cuda {
namespace {

constexpr unsigned kAllLanes = 0xffffffffu;
constexpr int kBlock = 128;
constexpr std::uint32_t kHole = 0x80000000u;  // in an entry of the list, beside the pixel's number

__global__ void find_discontinuities(DisparityView map, RasterView<std::uint8_t> out) {
    const int2 at = pixel_of_thread();
    if (at.x >= map.width || at.y >= map.height) return;
    const int own = map.at(at.x, at.y);
    out.at(at.x, at.y) =
        step::discontinuous(own, map.at(at.x - 1, at.y)) | step::discontinuous(own, map.at(at.x + 1, at.y)) |
        step::discontinuous(own, map.at(at.x, at.y - 1)) | step::discontinuous(own, map.at(at.x, at.y + 1));
}

// The pixels that have a window, in any order; the others are copied.
__global__ void list_pixels(VoteInput in, VoteArrays arrays, DisparityOut voted) {
    const int2 at = pixel_of_thread();
    const bool inside = at.x < in.map.width && at.y < in.map.height;
    bool hole = false, near = false;
    if (inside) {
        hole = in.matched.origin && !in.matched.at(at.x, at.y);
#pragma unroll
        for (int j = -step::kNear_px; j <= step::kNear_px; ++j)
#pragma unroll
            for (int i = -step::kNear_px; i <= step::kNear_px; ++i)
                near |= arrays.discontinuous.at(at.x + i, at.y + j) != 0;
    }
    const bool listed = inside && (hole || near);
    if (inside && !listed) voted.at(at.x, at.y) = in.map.at(at.x, at.y);
    const unsigned lanes = __ballot_sync(kAllLanes, listed);
    if (lanes == 0) return;
    unsigned first = 0;
    if (threadIdx.x == 0) first = atomicAdd(arrays.count, static_cast<unsigned>(__popc(lanes)));
    first = __shfl_sync(kAllLanes, first, 0);
    if (listed)
        arrays.list[first + __popc(lanes & ((1u << threadIdx.x) - 1))] =
            (static_cast<std::uint32_t>(at.y) * in.map.width + at.x) | (hole ? kHole : 0);
}

__device__ unsigned sum_of_lanes(unsigned value) {
#if __CUDA_ARCH__ >= 800
    return __reduce_add_sync(kAllLanes, value);
#else
    return reduce_warp(value, [](unsigned a, unsigned b) { return a + b; });
#endif
}

// A pixel of a window, whose vote a lane casts.
struct Voter {
    int i, j;                  // in strides from the middle
    std::uint16_t near, hole;  // weight by distance in both kinds of window; 0 = there is none
};
struct Vote {
    std::int16_t disparity;
    std::uint16_t weight;
};
constexpr int kVotesPerLane = (step::kVotes + 31) / 32;

__device__ Voter voter_of(int number) {
    constexpr int kSide = 2 * step::kVoteRadius + 1;
    if (number >= step::kVotes) return {0, 0, 0, 0};
    const int j = number / kSide - step::kVoteRadius, i = number % kSide - step::kVoteRadius;
    const int ring = max(abs(i), abs(j));
    return {i, j, step::distance_weight(step::kNearStride, ring),
            step::distance_weight(step::kHoleStride, ring)};
}

// The pixel in the middle of a window.
struct Middle {
    const PixelRecord* at;
    const std::int32_t* nearest_seen;  // of its row
    int x;
    std::uint32_t color;  // hole_color in holes
    bool hole;
};

// In the border nothing has a weight.
__device__ Vote vote_of(const VoteInput& in, const Middle& middle, const Voter& voter) {
    const int stride = middle.hole ? step::kHoleStride : step::kNearStride, dx = voter.i * stride,
              dy = voter.j * stride;
    const PixelRecord from = read_record(middle.at + (dy * in.records.stride + dx));
    Vote vote;
    const std::uint8_t change = color_step(middle.color, middle.hole ? from.hole_color : from.color);
    vote.weight = step::vote_weight(middle.hole ? step::hole_likeness(change) : step::near_likeness(change),
                                    middle.hole ? voter.hole : voter.near,
                                    static_cast<std::uint8_t>(from.vote_weight), from.disparity);
    vote.disparity = step::vote(from.disparity, from.slope_x, from.slope_y, static_cast<std::int16_t>(dx),
                                static_cast<std::int16_t>(dy));
    const int column = step::matching_column(middle.x, in.min_px, vote.disparity);
    if (column >= 0 && column < in.map.width && step::hides(middle.nearest_seen[column], vote.disparity))
        vote.weight = 0;
    return vote;
}

// A warp takes a pixel at a time.
__global__ void __launch_bounds__(kBlock)
    take_votes_kernel(VoteInput in, const std::uint32_t* __restrict__ list,
                      const std::uint32_t* __restrict__ list_count, DisparityOut voted) {
    const unsigned count = *list_count, warps = gridDim.x * (kBlock / 32);
    const int lane = static_cast<int>(threadIdx.x % 32);
    Voter voters[kVotesPerLane];
#pragma unroll
    for (int v = 0; v < kVotesPerLane; ++v) voters[v] = voter_of(lane + 32 * v);
    for (unsigned k = (blockIdx.x * kBlock + threadIdx.x) / 32; k < count; k += warps) {
        const std::uint32_t entry = list[k], pixel = entry & ~kHole;
        const int y = static_cast<int>(pixel / in.map.width), x = static_cast<int>(pixel - y * in.map.width);
        const PixelRecord* const at = &in.records.at(x, y);
        const PixelRecord record = read_record(at);
        const bool hole = (entry & kHole) != 0;
        const Middle own{at, in.nearest_seen.row(y), x, hole ? record.hole_color : record.color, hole};
        Vote votes[kVotesPerLane];
        unsigned weight = 0, lowest = INT16_MAX, highest = 0;
#pragma unroll
        for (int v = 0; v < kVotesPerLane; ++v) {
            votes[v] = vote_of(in, own, voters[v]);
            const auto disparity = static_cast<unsigned>(votes[v].disparity);
            weight += votes[v].weight;
            lowest = min(lowest, votes[v].weight ? disparity : unsigned{INT16_MAX});
            highest = max(highest, votes[v].weight ? disparity : 0u);
        }
        const auto total = static_cast<std::uint16_t>(sum_of_lanes(weight));
        auto hi = static_cast<std::int16_t>(most_of_lanes(highest));
        auto lo = static_cast<std::int16_t>(least_of_lanes(lowest));
        while (lo < hi) {
            const std::int16_t middle = step::middle(lo, hi);
            unsigned up_to_middle = 0;
#pragma unroll
            for (int v = 0; v < kVotesPerLane; ++v)
                up_to_middle += votes[v].disparity <= middle ? votes[v].weight : 0;
            step::narrow(static_cast<std::uint16_t>(sum_of_lanes(up_to_middle)), total, lo, hi);
        }
        if (lane == 0) voted.at(x, y) = total ? lo : in.map.at(x, y);
    }
}

}  // namespace

void take_votes(cudaStream_t stream, const VoteInput& input, const VoteArrays& arrays,
                const DisparityOut& voted) {
    const dim3 grid = pixel_grid(input.map.width, input.map.height);
    check(cudaMemsetAsync(arrays.count, 0, sizeof(std::uint32_t), stream), "clearing");
    find_discontinuities<<<grid, pixel_block(), 0, stream>>>(input.map, arrays.discontinuous);
    check_launch("finding discontinuities");
    list_pixels<<<grid, pixel_block(), 0, stream>>>(input, arrays, voted);
    check_launch("listing pixels");
    constexpr int kMostBlocks =
        132 * 16;  // several rounds each on any device, where there is that much to do
    const int blocks = std::min(
        kMostBlocks, blocks_for(static_cast<std::size_t>(input.map.width) * input.map.height, kBlock / 32));
    take_votes_kernel<<<blocks, kBlock, 0, stream>>>(input, arrays.list, arrays.count, voted);
    check_launch("taking votes");
}

}  // namespace hexrelief::cuda
