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

using PixelBits = RasterView<const std::uint32_t>;

__global__ void find_discontinuities(DisparityView map, RasterView<std::uint32_t> out) {
    const int2 at = pixel_of_thread();
    if (at.y >= map.height) return;  // a warp together
    const int own = at.x < map.width ? map.at(at.x, at.y) : kUnknown16;
    const bool found =
        step::discontinuous(own, map.at(at.x - 1, at.y)) | step::discontinuous(own, map.at(at.x + 1, at.y)) |
        step::discontinuous(own, map.at(at.x, at.y - 1)) | step::discontinuous(own, map.at(at.x, at.y + 1));
    const std::uint32_t bits = __ballot_sync(kAllLanes, found);
    if (threadIdx.x == 0) out.at(static_cast<int>(blockIdx.x), at.y) = bits;
}

// Of a warp's 32 pixels those within kNear_px of a discontinuity. A warp calls together.
__device__ std::uint32_t near_discontinuities(const PixelBits& discontinuous, int y) {
    constexpr int kRows = 2 * step::kNear_px + 1;
    const int lane = static_cast<int>(threadIdx.x), row = y + lane % kRows - step::kNear_px,
              beside = lane / kRows - 1, column = static_cast<int>(blockIdx.x) + beside;
    const bool inside =
        beside <= 1 && row >= 0 && row < discontinuous.height && column >= 0 && column < discontinuous.width;
    const std::uint32_t bits = inside ? discontinuous.at(column, row) : 0;
    const auto any_row = [&](int of) { return any_of_lanes(beside == of ? bits : 0); };
    const std::uint32_t before = any_row(-1), here = any_row(0), behind = any_row(1);
    std::uint32_t near = here;
#pragma unroll
    for (int k = 1; k <= step::kNear_px; ++k)
        near |= __funnelshift_l(before, here, k) | __funnelshift_r(here, behind, k);
    return near;
}

// Pixels that have a window, y in the upper halves of words, x in the lower ones, in any order: holes from
// the list's begin on, pixels near discontinuities from its end. The others are copied.
enum Kind { kHole, kNear, kKinds };
struct PixelList {
    std::uint32_t* pixels;
    std::uint32_t* counts;  // by kind
    std::size_t size;

    __device__ std::uint32_t& at(Kind kind, std::uint32_t i) const {
        return kind == kHole ? pixels[i] : pixels[size - 1 - i];
    }
};

// A block adds its pixels together: as many atomic additions as there are warps would wait for each other.
struct BlockCounts {
    unsigned counts[kKinds], firsts[kKinds];
};
__device__ void add_to_list(const PixelList& list, const bool (&listed)[kKinds], std::uint32_t pixel,
                            BlockCounts& block) {
    const unsigned thread = threadIdx.y * 32 + threadIdx.x;
    if (thread < kKinds) block.counts[thread] = 0;
    __syncthreads();
    unsigned lanes[kKinds], before[kKinds] = {};
    for (int kind = 0; kind < kKinds; ++kind) {
        lanes[kind] = __ballot_sync(kAllLanes, listed[kind]);
        if (threadIdx.x == 0)
            before[kind] = atomicAdd(&block.counts[kind], static_cast<unsigned>(__popc(lanes[kind])));
        before[kind] = __shfl_sync(kAllLanes, before[kind], 0);
    }
    __syncthreads();
    if (thread < kKinds && block.counts[thread] > 0)
        block.firsts[thread] = atomicAdd(list.counts + thread, block.counts[thread]);
    __syncthreads();
    for (int kind = 0; kind < kKinds; ++kind)
        if (listed[kind])
            list.at(static_cast<Kind>(kind),
                    block.firsts[kind] + before[kind] + count_before_lane(lanes[kind])) = pixel;
}

__global__ void list_pixels(VoteInput in, PixelBits discontinuous, PixelList list, DisparityOut voted) {
    __shared__ BlockCounts block;
    const int2 at = pixel_of_thread();
    const bool is_near = near_discontinuities(discontinuous, at.y) >> threadIdx.x & 1u;
    const bool inside = at.x < in.map.width && at.y < in.map.height;
    const bool hole = inside && in.matched.origin && !in.matched.at(at.x, at.y),
               near = inside && is_near && !hole;
    if (inside && !hole && !near) voted.at(at.x, at.y) = in.map.at(at.x, at.y);
    add_to_list(list, {hole, near}, static_cast<std::uint32_t>(at.y) << 16 | static_cast<std::uint32_t>(at.x),
                block);
}

// A pixel of a window, whose vote a lane casts.
struct alignas(16) Voter {
    int dx, dy, offset;    // from the middle, in px and in records
    unsigned at_distance;  // weight; 0 = there is none
};
constexpr int kVotesPerLane = (step::kMostVotes + 31) / 32, kVoters = 32 * kVotesPerLane;

// By a block. Of a window's places, row by row, the dark ones are every other, as a row has an odd number.
template <Kind kKind>
__device__ void list_voters(int row_stride, Voter (&voters)[kVoters]) {
    constexpr step::VoteReach reach = kKind == kHole ? step::kHoleVotes : step::kNearVotes;
    for (int number = static_cast<int>(threadIdx.x); number < kVoters; number += kBlock) {
        const int place = reach.dark_only ? 2 * number : number;
        const int j = place / reach.side() - reach.radius, i = place % reach.side() - reach.radius;
        const int dx = i * reach.stride, dy = j * reach.stride;
        voters[number] = number < reach.votes()
                             ? Voter{dx, dy, dy * row_stride + dx,
                                     step::distance_weight(kKind == kHole, max(abs(i), abs(j)))}
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
template <Kind kKind>
__device__ Vote vote_of(const VoteInput& in, const Middle& middle, const Voter& voter,
                        const PixelRecord& from) {
    const unsigned change = color_step(middle.color, kKind == kHole ? from.hole_color : from.color);
    const unsigned likeness =
        kKind == kHole ? step::hole_likeness<unsigned>(change) : step::near_likeness<unsigned>(change);
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
template <Kind kKind>
__device__ void vote_on_pixels(const VoteInput& in, const PixelList& list, const DisparityOut& voted) {
    const unsigned count = list.counts[kKind], warps = gridDim.x * (kBlock / 32);
    const int lane = static_cast<int>(threadIdx.x % 32);
    __shared__ Voter voters[kVoters];
    list_voters<kKind>(in.records.stride, voters);
    for (unsigned k = (blockIdx.x * kBlock + threadIdx.x) / 32; k < count; k += warps) {
        const std::uint32_t pixel = list.at(kKind, k);
        const int y = static_cast<int>(pixel >> 16), x = static_cast<int>(pixel & 0xffffu);
        const PixelRecord* const at = &in.records.at(x, y);
        const PixelRecord record = read_record(at);
        const std::uint32_t color = kKind == kHole ? record.hole_color : record.color;
        const Middle middle{x, y * in.nearest_seen.stride, color & ~kNoColor};  // may be unknown
        Vote votes[kVotesPerLane];
#pragma unroll
        for (int v = 0; v < kVotesPerLane; ++v) {
            const Voter voter = voters[lane + 32 * v];
            votes[v] = vote_of<kKind>(in, middle, voter, read_record(at + voter.offset));
        }
        const int median = median_of(votes, record.disparity);
        if (lane == 0) voted.at(x, y) = static_cast<std::int16_t>(median);
    }
}

__global__ void __launch_bounds__(kBlock)
    take_votes_kernel(VoteInput in, PixelList list, DisparityOut voted) {
    vote_on_pixels<kHole>(in, list, voted);
    vote_on_pixels<kNear>(in, list, voted);
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
    // several rounds each on any device, where there is that much to do; and more blocks than there is room
    // for at once, as some take longer
    constexpr int kMostBlocks = 132 * 48;
    take_votes_kernel<<<std::min(kMostBlocks, blocks_for(pixels, kBlock / 32)), kBlock, 0, stream>>>(
        input, list, voted);
    check_launch("taking votes");
}

}  // namespace hexrelief::cuda
