#include "cuda/matching/common/pixels.cuh"
#include "cuda/matching/sgm/path_costs.cuh"
#include "cuda/matching/sgm/winners.h"
#include "cuda/matching/sgm/word_access.cuh"
#include "pipeline/matching/sgm/window_step.h"
#include "pipeline/matching/sgm/winner_step.h"

namespace hexrelief::cuda {
namespace {

constexpr int kBlock = 256, kGroups = kBlock / kGroup;
constexpr int kPixelsOfBlock = 4 * kGroups;  // of a row

// The first of a pixel's entries in the sums; row: of the kept ones.
__device__ std::size_t entry_of_pixel(const DeviceVolume& volume, int x, int row) {
    const int margin = volume.band.kept.first - volume.band.rows.first;
    return (static_cast<std::size_t>(row + margin) * volume.width + x) * kSearched;
}

// The winner at left pixel x. along: pixels from one disparity to the next where the sums beside the winner's
// lie, 0 in the left view, 1 in the right one, whose pixels' costs are those of the left pixels that they
// match.
__device__ std::int16_t winner(const DeviceVolume& volume, const SearchWindow* windows, std::uint32_t key,
                               int x, int row, int along) {
    if (key >= kNoMatchKey) return kUnknown16;
    const int d = step::winner_disparity(key), before = x - along, behind = x + along;
    const bool inside = before >= 0 && behind < volume.width;
    const int lower = inside ? step::entry_of(windows[before], d - 1, volume.count) : -1,
              upper = inside ? step::entry_of(windows[behind], d + 1, volume.count) : -1;
    if (lower < 0 || upper < 0) return static_cast<std::int16_t>(kOnePixel * d);
    const auto sum = [&](int pixel, int entry) {
        return volume.sums[entry_of_pixel(volume, pixel, row) + DeviceVolume::place(entry)];
    };
    return static_cast<std::int16_t>(
        step::refined_winner(d, sum(before, lower), step::winner_sum(key), sum(behind, upper)));
}

// Sets the sums and the left view's winners. Of the right one, the block's pixels are those from its first
// one at the nearest disparity to its last one at the farthest: their best keys are found in shared memory,
// and joined to those of other blocks.
__global__ void __launch_bounds__(kBlock)
    find_sums_kernel(DeviceVolume volume, int min_px, std::uint32_t* right_keys,
                     RasterView<std::int16_t> left) {
    extern __shared__ std::uint32_t right[];
    const int row = static_cast<int>(blockIdx.y), first_x = static_cast<int>(blockIdx.x) * kPixelsOfBlock;
    const int y = volume.band.kept.first + row, lane = lane_of_group();
    const int reach = volume.count - 1, columns = kPixelsOfBlock + reach;
    for (int i = threadIdx.x; i < columns; i += kBlock) right[i] = step::kNoWinner;
    __syncthreads();
    const SearchWindow* const windows = volume.windows.row(y);
    for (int i = threadIdx.x / kGroup; i < kPixelsOfBlock; i += kGroups) {
        // All lanes take part in shuffles; a pixel behind the row's end is the last one, but says nothing.
        const bool exists = first_x + i < volume.width;
        const int x = exists ? first_x + i : volume.width - 1;
        const std::size_t entry = entry_of_pixel(volume, x, row) + lane * kLaneEntries;
        LanePairs sums, more;
        load_words<kLanePairs>(volume.sums_of_rows + entry, sums);
        load_words<kLanePairs>(volume.sums_of_columns + entry, more);
#pragma unroll
        for (int k = 0; k < kLanePairs; ++k) sums[k] += more[k];
        const int disparity = part_of_lane(packed(windows[x]), lane) * kLaneEntries;
        // The near run's lanes begin with the farther half: so no two lanes' columns share a bank.
        const bool far_half_first = lane >= kRunLanes;
        std::uint32_t best = step::kNoWinner;
#pragma unroll
        for (int k = 0; k < kLaneEntries; ++k) {
            const bool far_half = (k >= kLanePairs) != far_half_first;
            const std::uint32_t pair = sums[k % kLanePairs];
            const int d = disparity + k % kLanePairs + (far_half ? kLanePairs : 0);
            const std::uint32_t key = step::winner_key(
                static_cast<std::uint16_t>(far_half ? pair >> 16 : pair), static_cast<std::uint32_t>(d));
            if (!exists || d >= volume.count) continue;
            best = min(best, key);
            atomicMin(&right[x - first_x + reach - d], key);
        }
#pragma unroll
        for (int step = kGroup / 2; step > 0; step /= 2)
            best = min(best, __shfl_xor_sync(~0u, best, step, kGroup));
        if (exists) store_words<kLanePairs>(sums, volume.sums + entry);
        __syncwarp();
        if (exists && lane == 0) left.at(x, y) = winner(volume, windows, best, x, row, 0);
    }
    __syncthreads();
    for (int i = threadIdx.x; i < columns; i += kBlock) {
        const int xr = first_x + i - reach - min_px;
        if (xr >= 0 && xr < volume.width && right[i] != step::kNoWinner)
            atomicMin(&right_keys[static_cast<std::size_t>(row) * volume.width + xr], right[i]);
    }
}

__global__ void find_right_winners_kernel(DeviceVolume volume, int min_px, const std::uint32_t* right_keys,
                                          RasterView<std::int16_t> right) {
    const int2 at = pixel_of_thread();
    if (at.x >= volume.width || at.y >= volume.band.kept.count()) return;
    const int y = volume.band.kept.first + at.y;
    const std::uint32_t key = right_keys[static_cast<std::size_t>(at.y) * volume.width + at.x];
    right.at(at.x, y) =
        winner(volume, volume.windows.row(y), key, at.x + min_px + step::winner_disparity(key), at.y, 1);
}

}  // namespace

void find_winners(cudaStream_t stream, const DeviceVolume& volume, std::uint32_t* right_keys, int min_px,
                  const RasterView<std::int16_t>& left, const RasterView<std::int16_t>& right) {
    const int rows = volume.band.kept.count();
    const std::size_t pixels = static_cast<std::size_t>(volume.width) * rows;
    check(cudaMemsetAsync(right_keys, 0xff, pixels * sizeof(std::uint32_t), stream), "clearing winners");
    const dim3 grid(static_cast<unsigned>(blocks_for(volume.width, kPixelsOfBlock)),
                    static_cast<unsigned>(rows));
    const std::size_t columns = static_cast<std::size_t>(kPixelsOfBlock) + volume.count;
    find_sums_kernel<<<grid, kBlock, columns * sizeof(std::uint32_t), stream>>>(volume, min_px, right_keys,
                                                                                left);
    check_launch("finding the least sums");
    find_right_winners_kernel<<<pixel_grid(volume.width, rows), pixel_block(), 0, stream>>>(
        volume, min_px, right_keys, right);
    check_launch("finding the right view's winners");
}

}  // namespace hexrelief::cuda
