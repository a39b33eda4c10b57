#include "cuda/common/warp_reduce.cuh"
#include "cuda/matching/common/pixel_list.cuh"
#include "cuda/matching/refine/record_access.cuh"
#include "cuda/matching/refine/votes.h"
#include "pipeline/matching/refine/vote_step.h"
#include "pipeline/matching/refine/voter_step.h"

namespace hexrelief::cuda {
namespace {

constexpr unsigned kAllLanes = 0xffffffffu;
enum Kind { kHole, kNear };  // kinds of pixels that have a window

using PixelBits = matching::RasterView<const std::uint32_t>;

// Returns which of a warp's 32 pixels are within kNear_px of a discontinuity. All lanes call it.
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

// Lists the pixels near discontinuities, and copies those that are neither listed nor holes.
__global__ void list_near_pixels(VoteInput in, VoteArrays out, matching::DisparityOut voted) {
    begin_kernel();
    const int2 at = pixel_of_thread();
    const bool is_near = near_discontinuities(in.discontinuous, at.y) >> threadIdx.x & 1u;
    const bool inside = at.x < in.map.width && at.y < in.map.height;
    const bool hole = inside && in.weights.origin && step::is_hole(in.weights.at(at.x, at.y)),
               near = inside && is_near && !hole;
    if (inside && !hole && !near) voted.at(at.x, at.y) = in.map.at(at.x, at.y);
    add_to_list(out.near, near, at);
    const bool changes = __syncthreads_or(hole || near) != 0;
    if (threadIdx.x == 0 && threadIdx.y == 0)
        out.changed_blocks.at(static_cast<int>(blockIdx.x), static_cast<int>(blockIdx.y)) = changes;
}

// A pixel of a window, whose vote a lane casts.
struct alignas(16) Voter {
    int steps, offset;     // offset from the middle, as packed_steps() and in records
    unsigned at_distance;  // weight at its distance; 0 = there is no voter
};
constexpr int kVotesPerLane = (step::kMostVotes + 31) / 32, kVoters = 32 * kVotesPerLane;

// Lists the voters of a window by a block. If only the dark places count, they are every other one in row
// order, because rows have an odd number of places.
template <Kind kKind>
__device__ void list_voters(int row_stride, Voter (&voters)[kVoters]) {
    constexpr step::VoteReach reach = kKind == kHole ? step::kHoleVotes : step::kNearVotes;
    for (int number = static_cast<int>(threadIdx.x); number < kVoters; number += kListBlock) {
        const int place = reach.dark_only ? 2 * number : number;
        const int j = place / reach.side() - reach.radius, i = place % reach.side() - reach.radius;
        const int dx = i * reach.stride, dy = j * reach.stride;
        voters[number] = number < reach.votes()
                             ? Voter{packed_steps(dx, dy), dy * row_stride + dx,
                                     step::distance_weight(kKind == kHole, max(abs(i), abs(j)))}
                             : Voter{};
    }
    __syncthreads();
}

struct Vote {
    int disparity;
    unsigned weight;
};

// The pixel in the middle of a window.
struct Middle {
    int x;
    const std::int32_t* nearest_seen;  // the row's
    std::uint32_t color;               // hole_color in holes
};

// Returns a voter's vote; pixels of the border have weight 0.
template <Kind kKind>
__device__ Vote vote_of(const VoteInput& in, const Middle& middle, const Voter& voter,
                        const PixelRecord& from) {
    const unsigned change = color_step(middle.color, kKind == kHole ? from.hole_color : from.color);
    const unsigned likeness =
        kKind == kHole ? step::hole_likeness<unsigned>(change) : step::near_likeness<unsigned>(change);
    // an unknown pixel has no colour, so its weight is 0 anyway
    Vote vote{step::vote<int>(from.disparity, plane_change(from.slopes, voter.steps)),
              step::vote_weight<unsigned>(likeness, voter.at_distance, from.vote_weight, true)};
    const auto column = static_cast<unsigned>(step::matching_column(middle.x, in.min_px, vote.disparity));
    if (column < static_cast<unsigned>(in.map.width) &&
        step::hides(middle.nearest_seen[column], vote.disparity))
        vote.weight = 0;
    return vote;
}

// A lane's votes: disparities in the halves of words, weights in the bytes of one word.
static_assert(kVotesPerLane == 3);
struct LaneVotes {
    std::uint32_t more_by_two[2], weights;

    __device__ explicit LaneVotes(const Vote (&votes)[kVotesPerLane])
        : more_by_two{static_cast<std::uint32_t>(votes[0].disparity) + 2 * kBoth +
                          (static_cast<std::uint32_t>(votes[1].disparity) << 16),
                      static_cast<std::uint32_t>(votes[2].disparity) + 2},
          weights(votes[0].weight | votes[1].weight << 8 | votes[2].weight << 16) {}
    // Returns the weight of the votes that are at least as large as a disparity. complement: the disparity's
    // inverted bits, in both halves.
    __device__ unsigned weight_from(std::uint32_t complement) const {
        return __dp2a_lo(step::reaching(more_by_two[0], complement), weights,
                         __dp2a_hi(step::reaching(more_by_two[1], complement), weights, 0u));
    }
};

// Returns the weighted median of a warp's votes: the largest disparity that more than half of the
// weight reaches, found by step::median_by_bits(). Returns `otherwise` if
// all weights are 0.
__device__ int median_of(const Vote (&votes)[kVotesPerLane], int otherwise) {
    unsigned weight = 0, lowest = INT16_MAX, highest = 0;
#pragma unroll
    for (const Vote& vote : votes) {
        const auto disparity = static_cast<unsigned>(vote.weight ? vote.disparity : max(otherwise, 0));
        weight += vote.weight;
        lowest = min(lowest, disparity);
        highest = max(highest, disparity);
    }
    const unsigned total = sum_of_lanes(weight), least = least_of_lanes(lowest),
                   range = most_of_lanes(highest) - least;
    const LaneVotes lane(votes);
    const unsigned median = step::median_by_bits(
        least, 1u << (32 - __clz(static_cast<int>(range))) >> 1, total,
        [&](unsigned disparity) { return sum_of_lanes(lane.weight_from(~(disparity * kBoth))); });
    return total ? static_cast<int>(median) : otherwise;
}

// Votes on the listed pixels, one pixel at a time per warp.
template <Kind kKind>
__device__ void vote_on_pixels(const VoteInput& in, const PixelList& list,
                               const matching::DisparityOut& voted) {
    const unsigned count = *list.count, warps = gridDim.x * (kListBlock / 32),
                   // broadcast from lane 0, so that the compiler knows that it is the same in all lanes
        warp = __shfl_sync(kAllLanes, threadIdx.x / 32, 0);
    const int lane = static_cast<int>(threadIdx.x % 32);
    __shared__ Voter voters[kVoters];
    list_voters<kKind>(in.records.stride, voters);
    for (unsigned k = blockIdx.x * (kListBlock / 32) + warp; k < count; k += warps) {
        const auto [x, y] = listed_pixel(list, k);
        const PixelRecord* const at = &in.records.at(x, y);
        const PixelRecord record = read_record(at);
        const std::uint32_t color = kKind == kHole ? record.hole_color : record.color;
        const Middle middle{x, in.nearest_seen.row(y), color & ~kNoColor};  // the pixel may be unknown
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

__global__ void __launch_bounds__(kListBlock)
    take_votes_kernel(VoteInput in, PixelList near, matching::DisparityOut voted) {
    begin_kernel();
    if (in.weights.origin) vote_on_pixels<kHole>(in, in.holes, voted);
    vote_on_pixels<kNear>(in, near, voted);
}

}  // namespace

VoteArrays take_vote_arrays(Arena& arena, int width, int height, const PixelList& near) {
    const dim3 grid = pixel_blocks(width, height).grid;
    return {near, take_plain_raster<std::uint8_t>(arena, static_cast<int>(grid.x), static_cast<int>(grid.y))};
}

void take_votes(cudaStream_t stream, const VoteInput& input, const VoteArrays& arrays,
                const matching::DisparityOut& voted) {
    const int width = input.map.width, height = input.map.height;
    launch("listing pixels", stream, pixel_blocks(width, height), list_near_pixels, input, arrays, voted);
    launch("taking votes", stream, list_blocks(width, height), take_votes_kernel, input, arrays.near, voted);
}

}  // namespace hexrelief::cuda
