#include "cuda/matching/refine/frame_segments.h"

#include <vector>

#include "cuda/common/warp_reduce.cuh"
#include "cuda/matching/common/pixels.cuh"
#include "pipeline/matching/refine/frame_segment_step.h"

namespace hexrelief::cuda {
namespace {

constexpr int kBlock = 512;

using KnownRows = matching::RasterView<const std::uint32_t>;
// Returns the pixel's match, as it was before the map was filled.
__device__ std::int16_t match_of(const KnownRows& known, std::int16_t filled, int x, int y) {
    return known.at(x / 32, y) >> x % 32 & 1u ? filled : matching::kUnknown16;
}

// Returns the sum over a block's threads to all of them.
__device__ int sum_of_block(int value) {
    __shared__ int sum;
    __syncthreads();
    if (threadIdx.x == 0) sum = 0;
    __syncthreads();
    const auto of_warp = static_cast<int>(sum_of_lanes(static_cast<unsigned>(value)));
    if (threadIdx.x % 32 == 0) atomicAdd(&sum, of_warp);
    __syncthreads();
    return sum;
}

// Returns how many of a segment's samples are at most `most`.
__device__ int count_up_to(const std::int16_t* samples, int count, int most) {
    int up_to = 0;
    for (int i = static_cast<int>(threadIdx.x); i < count; i += kBlock)
        up_to += samples[i] != matching::kUnknown16 && samples[i] <= most;
    return sum_of_block(up_to);
}

// Finds the least disparity of segments, one segment per block.
__global__ void __launch_bounds__(kBlock)
    find_least(KnownRows known, matching::DisparityView filled, matching::CellGrid grid, FrameArrays arrays) {
    begin_kernel();
    const int first = arrays.firsts[blockIdx.x], count = arrays.firsts[blockIdx.x + 1] - first;
    const int* const cells = arrays.cells + first;
    std::int16_t* const samples = arrays.samples + first;
    for (int i = static_cast<int>(threadIdx.x); i < count; i += kBlock) {
        const int x = step::middle_of_cell(cells[i] % grid.columns, grid.cell_px),
                  y = step::middle_of_cell(cells[i] / grid.columns, grid.cell_px);
        samples[i] = step::unmatched(match_of(known, filled.at(x, y), x, y), filled.at(x, y));
    }
    __syncthreads();
    const int unmatched = count_up_to(samples, count, INT16_MAX);
    int least = matching::kUnknown16;
    if (step::may_be_beyond_frame(unmatched, count - unmatched)) {
        // number of samples that are not larger than the result
        const int wanted = step::upper_quartile(unmatched) + 1;
        int low = 0, high = INT16_MAX;
        while (low < high) {
            const int middle = (low + high) / 2;
            if (count_up_to(samples, count, middle) >= wanted)
                high = middle;
            else
                low = middle + 1;
        }
        least = low;
    }
    for (int i = static_cast<int>(threadIdx.x); i < count; i += kBlock)
        arrays.least[cells[i]] = static_cast<std::int16_t>(least);
}

__global__ void raise_pixels(KnownRows known, matching::CellGrid grid, const std::int16_t* least,
                             matching::DisparityOut filled) {
    begin_kernel();
    const int2 at = pixel_of_thread();
    const int column = at.x / grid.cell_px, row = at.y / grid.cell_px;
    if (column >= grid.columns || row >= grid.rows) return;
    std::int16_t& own = filled.at(at.x, at.y);
    own = step::raised(match_of(known, own, at.x, at.y), own, least[row * grid.columns + column]);
}

}  // namespace

FrameArrays take_frame_arrays(Arena& arena, const matching::CellGrid& grid) {
    return {arena.take<int>(grid.size()), arena.take<int>(grid.size() + 1),
            arena.take<std::int16_t>(grid.size()), arena.take<std::int16_t>(grid.size())};
}

void raise_frame_segments(Workspace& work, const matching::FrameSegments& segments, const FrameArrays& arrays,
                          const matching::RasterView<const std::uint32_t>& known,
                          const matching::DisparityOut& filled) {
    const matching::CellGrid& grid = segments.grid;
    if (segments.count() == 0) return;
    const cudaStream_t stream = work.stream, side = work.side.get();
    work.staging.upload(side, arrays.cells, segments.cells.data(), segments.cells.size());
    work.staging.upload(side, arrays.firsts, segments.firsts.data(), segments.firsts.size());
    work.side.mark();
    work.side.let_wait_for_mark(stream);
    launch("finding what segments beside the frame have", stream, {segments.count(), kBlock}, find_least,
           known, reading(filled), grid, arrays);
    launch("raising segments beside the frame", stream,
           pixel_blocks(segments.columns * grid.cell_px, filled.height), raise_pixels, known, grid,
           arrays.least, filled);
}

}  // namespace hexrelief::cuda
