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

__global__ void find_discontinuities(DisparityView map, RasterView<std::uint8_t> out) {
    const int2 at = pixel_of_thread();
    if (at.x >= map.width || at.y >= map.height) return;
    const int own = map.at(at.x, at.y);
    out.at(at.x, at.y) =
        step::discontinuous(own, map.at(at.x - 1, at.y)) | step::discontinuous(own, map.at(at.x + 1, at.y)) |
        step::discontinuous(own, map.at(at.x, at.y - 1)) | step::discontinuous(own, map.at(at.x, at.y + 1));
}

// Numbers of pixels that have a window, in any order: holes from the list's begin on, pixels near
// discontinuities from its end. The others are copied.
struct PixelList {
    std::uint32_t* pixels;
    std::uint32_t* counts;  // of holes, of the others
    std::size_t size;

    __device__ std::uint32_t& at(bool hole, std::uint32_t i) const {
        return hole ? pixels[i] : pixels[size - 1 - i];
    }
    // A warp calls together.
    __device__ void add(bool hole, bool listed, std::uint32_t pixel) const {
        const unsigned lanes = __ballot_sync(kAllLanes, listed);
        if (lanes == 0) return;
        unsigned first = 0;
        if (threadIdx.x == 0) first = atomicAdd(counts + !hole, static_cast<unsigned>(__popc(lanes)));
        first = __shfl_sync(kAllLanes, first, 0);
        if (listed) at(hole, first + count_before_lane(lanes)) = pixel;
    }
};

__global__ void list_pixels(VoteInput in, RasterView<const std::uint8_t> discontinuous, PixelList list,
                            DisparityOut voted) {
    const int2 at = pixel_of_thread();
    const bool inside = at.x < in.map.width && at.y < in.map.height;
    bool hole = false, near = false;
    if (inside) {
        hole = in.matched.origin && !in.matched.at(at.x, at.y);
#pragma unroll
        for (int j = -step::kNear_px; j <= step::kNear_px; ++j)
#pragma unroll
            for (int i = -step::kNear_px; i <= step::kNear_px; ++i)
                near |= discontinuous.at(at.x + i, at.y + j) != 0;
    }
    if (inside && !hole && !near) voted.at(at.x, at.y) = in.map.at(at.x, at.y);
    const std::uint32_t pixel = static_cast<std::uint32_t>(at.y) * in.map.width + at.x;
    list.add(true, inside && hole, pixel);
    list.add(false, inside && near && !hole, pixel);
}

__device__ unsigned sum_of_lanes(unsigned value) {
#if __CUDA_ARCH__ >= 800
    return __reduce_add_sync(kAllLanes, value);
#else
    return reduce_warp(value, [](unsigned a, unsigned b) { return a + b; });
#endif
}

// A pixel of a window, whose vote a lane casts.
struct alignas(16) Voter {
    int dx, dy, offset;    // from the middle, in px and in records
    unsigned at_distance;  // weight; 0 = there is none
};
constexpr int kVotesPerLane = (step::kMostVotes + 31) / 32, kVoters = 32 * kVotesPerLane;

// By a block. Of a window's places, row by row, the dark ones are every other, as a row has an odd number.
template <bool kHole>
__device__ void list_voters(int row_stride, Voter (&voters)[kVoters]) {
    constexpr step::VoteReach reach = kHole ? step::kHoleVotes : step::kNearVotes;
    for (int number = static_cast<int>(threadIdx.x); number < kVoters; number += kBlock) {
        const int place = reach.dark_only ? 2 * number : number;
        const int j = place / reach.side() - reach.radius, i = place % reach.side() - reach.radius;
        const int dx = i * reach.stride, dy = j * reach.stride;
        voters[number] = number < reach.votes() ? Voter{dx, dy, dy * row_stride + dx,
                                                        step::distance_weight(kHole, max(abs(i), abs(j)))}
                                                : Voter{0, 0, 0, 0};
    }
    __syncthreads();
}

struct Vote {
    int disparity;
    unsigned weight;
};

// The pixel in the middle of a window.
struct Middle {
    int x, first_of_row;
    std::uint32_t color;  // hole_color in holes
};

// In the border nothing has a weight.
template <bool kHole>
__device__ Vote vote_of(const VoteInput& in, const Middle& middle, const Voter& voter,
                        const PixelRecord& from) {
    const unsigned change = color_step(middle.color, kHole ? from.hole_color : from.color);
    const unsigned likeness =
        kHole ? step::hole_likeness<unsigned>(change) : step::near_likeness<unsigned>(change);
    Vote vote{
        step::vote<int>(from.disparity, slope_x(from), slope_y(from), voter.dx, voter.dy),
        step::vote_weight<unsigned>(likeness, voter.at_distance, from.vote_weight, from.disparity >= 0)};
    const int column = step::matching_column(middle.x, in.min_px, vote.disparity);
    if (column >= 0 && column < in.map.width &&
        step::hides(in.nearest_seen.origin[middle.first_of_row + column], vote.disparity))
        vote.weight = 0;
    return vote;
}

// The weighted median of a warp's votes; `otherwise` where none has a weight.
__device__ int median_of(const Vote (&votes)[kVotesPerLane], int otherwise) {
    unsigned weight = 0, lowest = INT16_MAX, highest = 0;
#pragma unroll
    for (const Vote& vote : votes) {
        const auto disparity = static_cast<unsigned>(vote.disparity);
        weight += vote.weight;
        lowest = min(lowest, vote.weight ? disparity : unsigned{INT16_MAX});
        highest = max(highest, vote.weight ? disparity : 0u);
    }
    const unsigned total = sum_of_lanes(weight);
    int hi = static_cast<int>(most_of_lanes(highest)), lo = static_cast<int>(least_of_lanes(lowest));
    while (lo < hi) {
        const int middle = step::middle(lo, hi);
        unsigned up_to_middle = 0;
#pragma unroll
        for (const Vote& vote : votes) up_to_middle += vote.disparity <= middle ? vote.weight : 0;
        step::narrow(sum_of_lanes(up_to_middle), total, lo, hi);
    }
    return total ? lo : otherwise;
}

// A warp takes a pixel at a time.
template <bool kHole>
__device__ void vote_on_pixels(const VoteInput& in, const PixelList& list, const DisparityOut& voted) {
    const unsigned count = list.counts[kHole ? 0 : 1], warps = gridDim.x * (kBlock / 32);
    const int lane = static_cast<int>(threadIdx.x % 32);
    __shared__ Voter voters[kVoters];
    list_voters<kHole>(in.records.stride, voters);
    for (unsigned k = (blockIdx.x * kBlock + threadIdx.x) / 32; k < count; k += warps) {
        const std::uint32_t pixel = list.at(kHole, k);
        const int y = static_cast<int>(pixel / in.map.width), x = static_cast<int>(pixel - y * in.map.width);
        const PixelRecord* const at = &in.records.at(x, y);
        const PixelRecord record = read_record(at);
        const std::uint32_t color = kHole ? record.hole_color : record.color;
        const Middle middle{x, y * in.nearest_seen.stride, color & ~kNoColor};  // may be unknown
        Vote votes[kVotesPerLane];
#pragma unroll
        for (int v = 0; v < kVotesPerLane; ++v) {
            const Voter voter = voters[lane + 32 * v];
            votes[v] = vote_of<kHole>(in, middle, voter, read_record(at + voter.offset));
        }
        const int median = median_of(votes, record.disparity);
        if (lane == 0) voted.at(x, y) = static_cast<std::int16_t>(median);
    }
}

__global__ void __launch_bounds__(kBlock)
    take_votes_kernel(VoteInput in, PixelList list, DisparityOut voted) {
    vote_on_pixels<true>(in, list, voted);
    vote_on_pixels<false>(in, list, voted);
}

}  // namespace

void take_votes(cudaStream_t stream, const VoteInput& input, const VoteArrays& arrays,
                const DisparityOut& voted) {
    const dim3 grid = pixel_grid(input.map.width, input.map.height);
    const std::size_t pixels = static_cast<std::size_t>(input.map.width) * input.map.height;
    const PixelList list{arrays.list, arrays.counts, pixels};
    check(cudaMemsetAsync(arrays.counts, 0, 2 * sizeof(std::uint32_t), stream), "clearing");
    find_discontinuities<<<grid, pixel_block(), 0, stream>>>(input.map, arrays.discontinuous);
    check_launch("finding discontinuities");
    list_pixels<<<grid, pixel_block(), 0, stream>>>(input, reading(arrays.discontinuous), list, voted);
    check_launch("listing pixels");
    // several rounds each on any device, where there is that much to do
    constexpr int kMostBlocks = 132 * 16;
    take_votes_kernel<<<std::min(kMostBlocks, blocks_for(pixels, kBlock / 32)), kBlock, 0, stream>>>(
        input, list, voted);
    check_launch("taking votes");
}

}  // namespace hexrelief::cuda
