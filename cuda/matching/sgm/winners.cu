#include "cuda/matching/sgm/volume.h"

#include "cuda/matching/common/pixels.cuh"
#include "cuda/matching/sgm/path_costs.cuh"
#include "pipeline/matching/sgm/window_step.h"

namespace hexrelief::cuda {
namespace {

constexpr int kBlock = 256, kGroups = kBlock / kGroup;
constexpr int kPixelsOfBlock = 192;  // pixels of a row in a block
template <int kRun>
constexpr int kSums = (kPixelsOfBlock + 2) * 2 * kRun;

// Keys from this one on mean no match.
constexpr std::uint32_t kNoMatchKey = 0xffffu << 16;

// A parabola's vertex lies within half a disparity of the smallest of three sums; if a neighbour's sum is
// smaller, the neighbour is the better match, whatever vertex results here.
constexpr int kVertexBits = 5, kLeastVertex = -matching::kOnePixel / 2;
static_assert(kMostDisparities << kVertexBits <= 1 << 16);
__device__ RightBest right_best(std::uint32_t key, int winner) {
    const int d = step::winner_disparity(key), vertex = winner - matching::kOnePixel * d;
    return (key & 0xffff0000u) |
           static_cast<std::uint32_t>(d << kVertexBits |
                                      (min(max(vertex, kLeastVertex), -kLeastVertex) - kLeastVertex));
}
__device__ std::int16_t right_winner(RightBest best) {
    const int vertex = static_cast<int>(best & ((1u << kVertexBits) - 1)) + kLeastVertex;
    return static_cast<std::int16_t>(
        matching::kOnePixel * static_cast<int>(best >> kVertexBits & (kMostDisparities - 1)) + vertex);
}

// A block's part of a row, in shared memory.
template <int kRun>
struct BlockRow {
    int width, first_x;
    matching::DisparityRange range;
    const PathPixel* pixels;  // the row's
    std::uint16_t* sums;      // the part's pixels and one on each side, in the layout of DeviceVolume
    // The smallest keys of its pixels, and of the pixels of the right view that they may match; `right`
    // begins with the match of the first pixel at the largest disparity.
    std::uint32_t *left, *right;

    __device__ std::uint16_t* sums_of(int x) const { return sums + (x - first_x + 1) * 2 * kRun; }
    __device__ int sum(int x, int entry) const { return sums_of(x)[DeviceVolume::place<kRun>(entry)]; }
    // Returns the winner at left pixel x. along: distance in pixels, per disparity, of the sums beside
    // the winner's: 0 in the left view, 1 in the right view, whose pixels' costs are those of the left
    // pixels that they match.
    __device__ std::int16_t winner(std::uint32_t key, int x, int along) const {
        if (key >= kNoMatchKey) return matching::kUnknown16;
        const int d = step::winner_disparity(key), before = x - along, behind = x + along;
        const bool inside = before >= 0 && behind < width;
        const int lower = inside ? step::entry_of(window_of(pixels[before]), d - 1, range) : -1,
                  upper = inside ? step::entry_of(window_of(pixels[behind]), d + 1, range) : -1;
        if (lower < 0 || upper < 0) return static_cast<std::int16_t>(matching::kOnePixel * d);
        return static_cast<std::int16_t>(
            step::refined_winner(d, sum(before, lower), step::winner_sum(key), sum(behind, upper)));
    }
};

// A lane's part of the sums of pixel x, within the part of the row or beside it, and its window.
template <int kRun>
struct LaneSums {
    LanePairs<kRun> rows, columns;
    PathPixel pixel;

    __device__ void read(const DeviceVolume& volume, const BlockRow<kRun>& row, std::size_t first_entry,
                         int x) {
        const std::size_t entry = first_entry + static_cast<std::size_t>(x) * 2 * kRun;
        load_pairs(volume.sums_of_rows + entry, rows);
        load_pairs(volume.sums_of_columns + entry, columns);
        pixel = row.pixels[x];
    }
    // Adds up both axes' sums, stores them in the row, and offers them as candidates for winners.
    __device__ void offer(const BlockRow<kRun>& row, int x) {
        uint4* const kept = reinterpret_cast<uint4*>(row.sums_of(x)) + lane_of_group();
#pragma unroll
        for (int k = 0; k < kPart<kRun>; ++k) rows[k] += columns[k];
#pragma unroll
        for (int k = 0; k < kPart<kRun>; k += 4)
            kept[k / 4 * kGroup] = make_uint4(rows[k], rows[k + 1], rows[k + 2], rows[k + 3]);
        const int i = x - row.first_x, count = row.range.count;
        if (i < 0 || i >= kPixelsOfBlock) return;
        const int in_run = kPart<kRun> * lane_of_group();
        const int far = far_run(pixel) + in_run, near = near_run(pixel) + in_run;
        // The key of a disparity beyond the range changes none, not even in `left`, which precedes `right`.
        std::uint32_t *const right_far = row.right + (i + count - 1 - far), *const right_near =
                                                                                row.right +
                                                                                (i + count - 1 - near);
        std::uint32_t best = step::kNoWinner;
        const auto offer = [&](std::uint32_t sum, int d, std::uint32_t* right) {
            const std::uint32_t key =
                step::winner_key(static_cast<std::uint16_t>(sum), static_cast<std::uint32_t>(d));
            const std::uint32_t inside = d < count ? key : step::kNoWinner;
            best = min(best, inside);
            atomicMin(right, inside);
        };
#pragma unroll
        for (int k = 0; k < kPart<kRun>; ++k) {
            offer(rows[k], far + k, right_far - k);
            offer(rows[k] >> 16, near + k, right_near - k);
        }
        atomicMin(&row.left[i], best);
    }
};

// Sets the left view's winners. For the right view, each block finds the best of its pixels' matches, and the
// blocks' results are combined.
template <int kRun>
__global__ void __launch_bounds__(kBlock)
    find_winners_kernel(DeviceVolume volume, matching::RasterView<std::int16_t> left) {
    begin_kernel();
    extern __shared__ uint4 shared[];  // 16 bytes at a time
    const int y = volume.band.kept.first + static_cast<int>(blockIdx.y);
    std::uint16_t* const sums = reinterpret_cast<std::uint16_t*>(shared);
    std::uint32_t* const keys = reinterpret_cast<std::uint32_t*>(sums + kSums<kRun>);
    const BlockRow<kRun> row{volume.width,
                             static_cast<int>(blockIdx.x) * kPixelsOfBlock,
                             volume.range,
                             volume.pixels.row(y),
                             sums,
                             keys,
                             keys + kPixelsOfBlock};
    const int thread = static_cast<int>(threadIdx.x), key_count = 2 * kPixelsOfBlock + row.range.count - 1;
    for (int i = thread; i < key_count; i += kBlock) keys[i] = step::kNoWinner;
    __syncthreads();
    const std::size_t first_pixel = static_cast<std::size_t>(y - volume.band.rows.first) * volume.width,
                      first_entry = first_pixel * 2 * kRun;
    // two pixels at once, so that the reads of both are in flight
    for (int i = thread / kGroup; i < kPixelsOfBlock + 2; i += 2 * kGroups) {
        LaneSums<kRun> sums[2];
        const auto inside = [&](int k) {
            const int number = i + k * kGroups, x = row.first_x + number - 1;
            return number < kPixelsOfBlock + 2 && x >= 0 && x < row.width;
        };
#pragma unroll
        for (int k = 0; k < 2; ++k)
            if (inside(k)) sums[k].read(volume, row, first_entry, row.first_x + i + k * kGroups - 1);
#pragma unroll
        for (int k = 0; k < 2; ++k)
            if (inside(k)) sums[k].offer(row, row.first_x + i + k * kGroups - 1);
    }
    __syncthreads();
    for (int i = thread; i < key_count; i += kBlock) {
        const std::uint32_t key = keys[i];
        if (i < kPixelsOfBlock) {
            const int x = row.first_x + i;
            if (x < row.width) left.at(x, y) = row.winner(key, x, 0);
            continue;
        }
        const int d = step::winner_disparity(key),
                  x = row.first_x + i - kPixelsOfBlock - (row.range.count - 1) + d,
                  right_x = x - d - row.range.min_px;
        if (!volume.right_best || key >= kNoMatchKey || right_x < 0 || right_x >= row.width) continue;
        atomicMin(&volume.right_best[first_pixel + right_x], right_best(key, row.winner(key, x, 1)));
    }
}

// Writes the band's rows of the right view.
__global__ void take_right_winners(const RightBest* right_best, const matching::Rows rows,
                                   matching::RasterView<std::int16_t> right) {
    begin_kernel();
    const int2 at = pixel_of_thread();
    if (at.x >= right.width || at.y >= rows.count()) return;
    const RightBest best = right_best[static_cast<std::size_t>(at.y) * right.width + at.x];
    right.at(at.x, rows.first + at.y) = best == kNoRightBest ? matching::kUnknown16 : right_winner(best);
}

}  // namespace

void find_winners(cudaStream_t stream, const DeviceVolume& volume,
                  const matching::RasterView<std::int16_t>& left,
                  const matching::RasterView<std::int16_t>& right) {
    const matching::Rows& kept = volume.band.kept;
    const dim3 grid(static_cast<unsigned>(blocks_for(volume.width, kPixelsOfBlock)),
                    static_cast<unsigned>(kept.count()));
    const bool wholly = matching::is_searched_wholly(volume.range);
    const std::size_t shared_bytes =
        (wholly ? kSums<matching::kLongRun> : kSums<matching::kShortRun>)*sizeof(std::uint16_t) +
        (std::size_t{2} * kPixelsOfBlock + volume.range.count) * sizeof(std::uint32_t);
    const auto kernel =
        wholly ? find_winners_kernel<matching::kLongRun> : find_winners_kernel<matching::kShortRun>;
    launch("finding the least sums", stream, {grid, kBlock, shared_bytes}, kernel, volume, left);
    if (!volume.right_best) return;
    launch("finding the right view's winners", stream, pixel_blocks(volume.width, kept.count()),
           take_right_winners,
           volume.right_best + static_cast<std::size_t>(kept.first - volume.band.rows.first) * volume.width,
           kept, right);
}

}  // namespace hexrelief::cuda
