#include "cuda/matching/sgm/paths.h"

#include <type_traits>

#include "cuda/matching/sgm/segments.cuh"

namespace hexrelief::cuda {
namespace {

constexpr int kBlock = 64;

// Both axes in one launch: the first blocks walk along rows.
struct Axes {
    Paths rows, columns;
    unsigned row_blocks;
};
__device__ LanePath path_of_thread(const Axes& axes) {
    const bool along_row = blockIdx.x < axes.row_blocks;
    const unsigned block = along_row ? blockIdx.x : blockIdx.x - axes.row_blocks;
    return {along_row ? axes.rows : axes.columns, block * kBlock + threadIdx.x};
}

__device__ int steps_in(const Paths& paths, int segment) {
    return min(kSegment, paths.steps - segment * kSegment);
}

__global__ void __launch_bounds__(kBlock) walk_forth_kernel(const __grid_constant__ Axes axes) {
    const LanePath path = path_of_thread(axes);
    const int last = (path.paths.steps - 1) / kSegment;
    PathCosts costs;
    costs.begin(path.window(0), path.paths.p1);
    Segment next = {};
    if (last > 0) next.read(path, 0, kSegment);
    for (int number = 0; number < last; ++number) {
        const Segment here = next;
        if (number + 1 < last) next.read(path, number + 1, kSegment);
        if (path.exists) store_words<kLanePairs>(costs.pairs, path.kept_before(number));
#pragma unroll
        for (int k = 0; k < kSegment; ++k) here.step_forth(path, k, costs);
    }
    if (path.exists) store_words<kLanePairs>(costs.pairs, path.kept_before(last));
}

// kWhole: steps == kSegment.
template <bool kWhole>
__device__ void walk_segment(const LanePath& path, const Segment& segment, int number, int steps,
                             PathCosts& back) {
    LanePairs sums[kSegment];
    PathCosts forth;
    forth.load(segment.start, segment.start_window);
#pragma unroll
    for (int k = 0; k < kSegment; ++k) {
        if (!kWhole && k >= steps) continue;
        segment.step_forth(path, k, forth);
#pragma unroll
        for (int i = 0; i < kLanePairs; ++i) sums[k][i] = forth.pairs[i];
    }
#pragma unroll
    for (int k = kSegment - 1; k >= 0; --k) {
        if (!kWhole && k >= steps) continue;
        segment.step_back(path, k, back);
#pragma unroll
        for (int i = 0; i < kLanePairs; ++i) sums[k][i] += back.pairs[i] - 2 * path.paths.p1;
        if (path.exists)
            store_words<kLanePairs>(sums[k], path.paths.sums + path.entry(number * kSegment + k));
    }
}

__global__ void __launch_bounds__(kBlock) walk_back_kernel(const __grid_constant__ Axes axes) {
    const LanePath path = path_of_thread(axes);
    int number = (path.paths.steps - 1) / kSegment;
    const int in_last = steps_in(path.paths, number);
    PathCosts back;
    back.begin(path.window(path.paths.steps - 1), path.paths.p1);
    Segment next = {};
    next.read_with_start(path, number, in_last);
    if (in_last < kSegment) {
        const Segment here = next;
        if (number > 0) next.read_with_start(path, number - 1, kSegment);
        walk_segment<false>(path, here, number--, in_last, back);
    }
    for (; number >= 0; --number) {
        const Segment here = next;
        if (number > 0) next.read_with_start(path, number - 1, kSegment);
        walk_segment<true>(path, here, number, kSegment, back);
    }
}

}  // namespace

KeptCosts take_kept_costs(Arena& arena, int width, int rows) {
    const auto entries = [](int paths, int steps) {
        return static_cast<std::size_t>(paths) * blocks_for(steps, kSegment) * kSearched;
    };
    return {arena.take<std::uint16_t>(entries(rows, width)), arena.take<std::uint16_t>(entries(width, rows))};
}

void walk_paths(cudaStream_t stream, const PairArrays& pair, const DeviceVolume& volume, int p1,
                const KeptCosts& kept) {
    const int width = volume.width, rows = volume.band.rows.count();
    const std::ptrdiff_t first = static_cast<std::ptrdiff_t>(volume.band.rows.first) * width;
    const auto* const windows = reinterpret_cast<const std::uint32_t*>(volume.windows.origin + first);
    const std::uint32_t pair_p1 = step::pair_of(static_cast<std::uint32_t>(p1));
    const std::ptrdiff_t segments_of_row = blocks_for(static_cast<std::size_t>(width), kSegment);
    Axes axes{{rows, width, width, 1, volume.costs, volume.sums_of_rows, pair.penalty_x + first, windows,
               kept.of_rows, segments_of_row, 1, pair_p1},
              {width, rows, 1, width, volume.costs, volume.sums_of_columns, pair.penalty_y + first, windows,
               kept.of_columns, 1, width, pair_p1},
              0};
    const auto blocks = [](int paths) {
        return static_cast<unsigned>(blocks_for(static_cast<std::size_t>(paths) * kGroup, kBlock));
    };
    axes.row_blocks = blocks(rows);
    const unsigned all = axes.row_blocks + blocks(width);
    walk_forth_kernel<<<all, kBlock, 0, stream>>>(axes);
    check_launch("walking paths forth");
    walk_back_kernel<<<all, kBlock, 0, stream>>>(axes);
    check_launch("walking paths back");
}

}  // namespace hexrelief::cuda
