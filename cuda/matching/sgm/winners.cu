#include "cuda/matching/sgm/winners.h"

#include "cuda/matching/common/pixels.cuh"
#include "cuda/matching/sgm/path_costs.cuh"
#include "pipeline/matching/sgm/winner_step.h"

namespace hexrelief::cuda {
namespace {

constexpr int kBlock = 256, kGroups = kBlock / kGroup;
constexpr int kPixelsOfBlock = 128;  // of a row
constexpr int kSums = (kPixelsOfBlock + 2) * kSearched;

// What has no match: a key from here on.
constexpr std::uint32_t kNoMatchKey = 0xffffu << 16;

// A block's part of a row, in shared memory.
struct BlockRow {
    int width, count, first_x;
    const PathPixel* pixels;  // of the row
    std::uint16_t* sums;      // of the part's pixels and of one on each side, as those of DeviceVolume
    // The least keys of its pixels, and of those of the right view that they may match, from the one at the
    // first pixel's nearest disparity on.
    std::uint32_t *left, *right;

    __device__ std::uint16_t* sums_of(int x) const { return sums + (x - first_x + 1) * kSearched; }
    __device__ int sum(int x, int entry) const { return sums_of(x)[DeviceVolume::place(entry)]; }
    // The winner at left pixel x. along: pixels from one disparity to the next where the sums beside the
    // winner's lie, 0 in the left view, 1 in the right one, whose pixels' costs are those of the left pixels
    // that they match.
    __device__ std::int16_t winner(std::uint32_t key, int x, int along) const {
        if (key >= kNoMatchKey) return kUnknown16;
        const int d = step::winner_disparity(key), before = x - along, behind = x + along;
        const bool inside = before >= 0 && behind < width;
        const int lower = inside ? step::entry_of(window_of(pixels[before]), d - 1, count) : -1,
                  upper = inside ? step::entry_of(window_of(pixels[behind]), d + 1, count) : -1;
        if (lower < 0 || upper < 0) return static_cast<std::int16_t>(kOnePixel * d);
        return static_cast<std::int16_t>(
            step::refined_winner(d, sum(before, lower), step::winner_sum(key), sum(behind, upper)));
    }
};

// The sums of pixel x of the part or beside it, by a group of lanes.
__device__ void take_sums(const DeviceVolume& volume, const BlockRow& row, std::size_t first_entry, int x) {
    if (x < 0 || x >= row.width) return;
    const std::size_t entry = first_entry + static_cast<std::size_t>(x) * kSearched;
    LanePairs sums, more;
    load_pairs(volume.sums_of_rows + entry, sums);
    load_pairs(volume.sums_of_columns + entry, more);
#pragma unroll
    for (int k = 0; k < kLanePairs; ++k) sums[k] += more[k];
    uint4* const kept = reinterpret_cast<uint4*>(row.sums_of(x)) + lane_of_group();
    kept[0] = make_uint4(sums[0], sums[1], sums[2], sums[3]);
    kept[kGroup] = make_uint4(sums[4], sums[5], sums[6], sums[7]);
    const int i = x - row.first_x;
    if (i < 0 || i >= kPixelsOfBlock) return;
    const int far = kPart * (far_part(row.pixels[x]) + lane_of_group()),
              near = kPart * (near_part(row.pixels[x]) + lane_of_group());
    std::uint32_t best = step::kNoWinner;
    const auto offer = [&](std::uint32_t sum, int d) {
        if (d >= row.count) return;
        const std::uint32_t key =
            step::winner_key(static_cast<std::uint16_t>(sum), static_cast<std::uint32_t>(d));
        best = min(best, key);
        atomicMin(&row.right[i + row.count - 1 - d], key);
    };
#pragma unroll
    for (int k = 0; k < kLanePairs; ++k) {
        offer(sums[k], far + k);
        offer(sums[k] >> 16, near + k);
    }
    atomicMin(&row.left[i], best);
}

// Sets the left view's winners. Of the right one, each block finds the best of what its pixels match, and
// these are joined.
__global__ void __launch_bounds__(kBlock)
    find_winners_kernel(DeviceVolume volume, int min_px, RightBest* right_best,
                        RasterView<std::int16_t> left) {
    extern __shared__ uint4 shared[];  // 16 bytes at a time
    const int kept_row = static_cast<int>(blockIdx.y), y = volume.band.kept.first + kept_row;
    std::uint16_t* const sums = reinterpret_cast<std::uint16_t*>(shared);
    std::uint32_t* const keys = reinterpret_cast<std::uint32_t*>(sums + kSums);
    const BlockRow row{volume.width,         volume.count, static_cast<int>(blockIdx.x) * kPixelsOfBlock,
                       volume.pixels.row(y), sums,         keys,
                       keys + kPixelsOfBlock};
    const int thread = static_cast<int>(threadIdx.x), key_count = 2 * kPixelsOfBlock + row.count - 1;
    for (int i = thread; i < key_count; i += kBlock) keys[i] = step::kNoWinner;
    __syncthreads();
    const std::size_t first_entry =
        static_cast<std::size_t>(y - volume.band.rows.first) * volume.width * kSearched;
    for (int i = thread / kGroup; i < kPixelsOfBlock + 2; i += kGroups)
        take_sums(volume, row, first_entry, row.first_x + i - 1);
    __syncthreads();
    for (int i = thread; i < key_count; i += kBlock) {
        const std::uint32_t key = keys[i];
        if (i < kPixelsOfBlock) {
            const int x = row.first_x + i;
            if (x < row.width) left.at(x, y) = row.winner(key, x, 0);
            continue;
        }
        const int d = step::winner_disparity(key), x = row.first_x + i - kPixelsOfBlock - (row.count - 1) + d,
                  right_x = x - d - min_px;
        if (key == step::kNoWinner || right_x < 0 || right_x >= row.width) continue;
        const auto winner = static_cast<std::uint16_t>(row.winner(key, x, 1));
        atomicMin(&right_best[static_cast<std::size_t>(kept_row) * row.width + right_x],
                  RightBest{key} << 16 | winner);
    }
}

__global__ void take_right_winners(const RightBest* right_best, const Rows rows,
                                   RasterView<std::int16_t> right) {
    const int2 at = pixel_of_thread();
    if (at.x >= right.width || at.y >= rows.count()) return;
    const RightBest best = right_best[static_cast<std::size_t>(at.y) * right.width + at.x];
    right.at(at.x, rows.first + at.y) = best == ~RightBest{0} ? kUnknown16 : static_cast<std::int16_t>(best);
}

}  // namespace

void find_winners(cudaStream_t stream, const DeviceVolume& volume, RightBest* right_best, int min_px,
                  const RasterView<std::int16_t>& left, const RasterView<std::int16_t>& right) {
    const Rows& kept = volume.band.kept;
    const std::size_t pixels = static_cast<std::size_t>(volume.width) * kept.count();
    check(cudaMemsetAsync(right_best, 0xff, pixels * sizeof(RightBest), stream), "clearing winners");
    const dim3 grid(static_cast<unsigned>(blocks_for(volume.width, kPixelsOfBlock)),
                    static_cast<unsigned>(kept.count()));
    const std::size_t shared_bytes = kSums * sizeof(std::uint16_t) +
                                     (std::size_t{2} * kPixelsOfBlock + volume.count) * sizeof(std::uint32_t);
    find_winners_kernel<<<grid, kBlock, shared_bytes, stream>>>(volume, min_px, right_best, left);
    check_launch("finding the least sums");
    take_right_winners<<<pixel_grid(volume.width, kept.count()), pixel_block(), 0, stream>>>(right_best, kept,
                                                                                             right);
    check_launch("finding the right view's winners");
}

}  // namespace hexrelief::cuda
