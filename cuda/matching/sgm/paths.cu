#include "cuda/matching/sgm/paths.h"

#include "cuda/matching/sgm/segments.cuh"

#include "cuda/matching/common/launch.cuh"

namespace hexrelief::cuda {
namespace {

constexpr int kBlock = 32;  // paths are few and long: the smallest blocks spread best

// Both axes in one launch: the first blocks walk along rows. blockIdx.y: half.
struct Axes {
    HalfPaths rows[2], columns[2];
    unsigned row_blocks;
    PairStep small_step;
};
template <int kRun>
__device__ LanePath<kRun> path_of_thread(const Axes& axes) {
    const bool along_row = blockIdx.x < axes.row_blocks;
    const unsigned block = along_row ? blockIdx.x : blockIdx.x - axes.row_blocks;
    return {along_row ? axes.rows[blockIdx.y] : axes.columns[blockIdx.y], block * kBlock + threadIdx.x};
}

// Pixels share their windows two by two (see find_path_pixels()), and each half begins at an even pixel;
// these functions say at which pixel k of a segment a step may lead to another window.
static_assert(kSegment % 2 == 0);
__device__ constexpr bool may_move_outwards(int k) {
    return k % 2 == 0;
}
__device__ constexpr bool may_move_inwards(int k) {
    return k % 2 != 0;
}

// kWhole: steps == kSegment.
template <bool kWhole, int kRun>
__device__ void walk_segment_inwards(const Axes& axes, const LanePath<kRun>& path,
                                     const Segment<kRun>& segment, int number, int steps,
                                     PathCosts<kRun>& inwards) {
    if (path.exists) store_pairs(inwards.pairs, path.kept_before(number));
#pragma unroll
    for (int k = kSegment - 1; k >= 0; --k)
        if (kWhole || k < steps)
            inwards.advance(segment.costs[k], axes.small_step, segment.inwards_to(path, k),
                            may_move_inwards(k));
}

template <int kRun>
__global__ void __launch_bounds__(kBlock) walk_inwards_kernel(const __grid_constant__ Axes axes) {
    begin_kernel();
    const LanePath<kRun> path = path_of_thread<kRun>(axes);
    PathCosts<kRun> inwards;
    inwards.begin(axes.small_step.p1);
    int number = path.segments() - 1;
    if (number >= 0) {
        inwards.move_to(path.at(path.paths.steps - 1));
        const int in_last = path.paths.steps - number * kSegment;
        Segment<kRun> next = {};
        next.read(path, number, in_last);
        if (in_last < kSegment) {
            const Segment<kRun> here = next;
            if (number > 0) next.read(path, number - 1);
            walk_segment_inwards<false>(axes, path, here, number--, in_last, inwards);
        }
        for (; number >= 0; --number) {
            const Segment<kRun> here = next;
            if (number > 0) next.read(path, number - 1);
            walk_segment_inwards<true>(axes, path, here, number, kSegment, inwards);
        }
    }
    if (path.exists) store_pairs(inwards.pairs, path.inwards());
}

// The costs of one direction at a segment's pixels, until those of the other direction are known; then
// the sums of both.
template <int kRun>
struct SegmentSums {
    LanePairs<kRun> pairs[kSegment];

    __device__ void keep(int k, const PathCosts<kRun>& costs) {
#pragma unroll
        for (int i = 0; i < kPart<kRun>; ++i) pairs[k][i] = costs.pairs[i];
    }
    __device__ void add(const Axes& axes, const LanePath<kRun>& path, int number, int k,
                        const PathCosts<kRun>& costs) {
#pragma unroll
        for (int i = 0; i < kPart<kRun>; ++i) pairs[k][i] += costs.pairs[i] - 2 * axes.small_step.p1;
        if (path.exists)
            store_pairs(pairs[k], path.paths.sums + path.pixel(number * kSegment + k) * path.kSearched);
    }
};

// Walks a segment in both directions at once, which meet in the middle.
template <int kRun>
__device__ void sum_segment(const Axes& axes, const LanePath<kRun>& path, const Segment<kRun>& segment,
                            int number, PathCosts<kRun>& outwards) {
    SegmentSums<kRun> sums;
    PathCosts<kRun> inwards;
    inwards.load(segment.start, segment.start_pixel);
#pragma unroll
    for (int k = 0; k < kSegment; ++k) {
        const int other = kSegment - 1 - k;
        // so it is true for both, or for none
        static_assert(may_move_inwards(kSegment - 1) == may_move_outwards(0));
        PathCosts<kRun>::advance_both(inwards, segment.costs[other], segment.inwards_to(path, other),
                                      outwards, segment.costs[k], segment.outwards_to(path, k),
                                      axes.small_step, may_move_outwards(k));
        if (k < other) {
            sums.keep(other, inwards);
            sums.keep(k, outwards);
        } else {
            sums.add(axes, path, number, other, inwards);
            sums.add(axes, path, number, k, outwards);
        }
    }
}

// Walks a path's last segment, which has fewer pixels, in one direction after the other.
template <int kRun>
__device__ void sum_last_segment(const Axes& axes, const LanePath<kRun>& path, const Segment<kRun>& segment,
                                 int number, int steps, PathCosts<kRun>& outwards) {
    SegmentSums<kRun> sums;
    PathCosts<kRun> inwards;
    inwards.load(segment.start, segment.start_pixel);
#pragma unroll
    for (int k = kSegment - 1; k >= 0; --k) {
        if (k >= steps) continue;
        inwards.advance(segment.costs[k], axes.small_step, segment.inwards_to(path, k), may_move_inwards(k));
        sums.keep(k, inwards);
    }
#pragma unroll
    for (int k = 0; k < kSegment; ++k) {
        if (k >= steps) continue;
        outwards.advance(segment.costs[k], axes.small_step, segment.outwards_to(path, k),
                         may_move_outwards(k));
        sums.add(axes, path, number, k, outwards);
    }
}

template <int kRun>
__global__ void __launch_bounds__(kBlock) walk_outwards_kernel(const __grid_constant__ Axes axes) {
    begin_kernel();
    const LanePath<kRun> path = path_of_thread<kRun>(axes);
    if (path.paths.steps == 0) return;
    LanePairs<kRun> start;
    load_pairs(path.outwards(), start);
    PathCosts<kRun> outwards;
    outwards.load(start, path.at(path.paths.other_steps > 0 ? -1 : 0));
    const int whole = path.paths.steps / kSegment, in_last = path.paths.steps % kSegment;
    Segment<kRun> next = {};
    const auto read_next = [&](int number) {
        if (number < path.segments()) next.read_start(path, number);
        if (number < whole)
            next.read(path, number);
        else if (in_last > 0)
            next.read(path, number, in_last);
    };
    read_next(0);
    for (int number = 0; number < whole; ++number) {
        const Segment<kRun> here = next;
        read_next(number + 1);
        sum_segment(axes, path, here, number, outwards);
    }
    if (in_last > 0) sum_last_segment(axes, path, next, whole, in_last, outwards);
}

// The whole paths of an axis.
struct Axis {
    int paths, steps;
    int next_path, next_step;  // in pixels
    const PathPixel* pixels;
    std::uint16_t* sums;
};

struct Halves {
    int steps[2];
};
Halves halves_of(int steps) {
    const int middle = steps / 2 / kSegment * kSegment;
    return {{middle, steps - middle}};
}

void set_half_paths(const DeviceVolume& volume, const Axis& axis, const KeptCosts::Axis& kept,
                    HalfPaths paths[2]) {
    const Halves halves = halves_of(axis.steps);
    for (int half = 0; half < 2; ++half) {
        const int other = 1 - half, way = half - other, first = halves.steps[0] - other;
        paths[half] = {axis.paths,
                       halves.steps[half],
                       static_cast<std::ptrdiff_t>(first) * axis.next_step,
                       axis.next_path,
                       way * axis.next_step,
                       volume.costs,
                       axis.sums,
                       axis.pixels,
                       kept.before_segments[half],
                       kept.at_middles[half],
                       kept.at_middles[other],
                       halves.steps[other],
                       other};
    }
}

}  // namespace

KeptCosts take_kept_costs(Arena& arena, int width, int rows, int searched) {
    const auto take = [&](int paths, int steps) {
        const std::size_t entries = static_cast<std::size_t>(paths) * searched;
        const Halves halves = halves_of(steps);
        KeptCosts::Axis kept{};
        for (int half = 0; half < 2; ++half) {
            kept.before_segments[half] =
                arena.take<std::uint16_t>(entries * blocks_for(halves.steps[half], kSegment));
            kept.at_middles[half] = arena.take<std::uint16_t>(entries);
        }
        return kept;
    };
    return {take(rows, width), take(width, rows)};
}

void walk_paths(cudaStream_t stream, const DeviceVolume& volume, int p1, const KeptCosts& kept) {
    const int width = volume.width, rows = volume.band.rows.count();
    const std::ptrdiff_t first = static_cast<std::ptrdiff_t>(volume.band.rows.first) * width;
    Axes axes{};
    set_half_paths(volume, {rows, width, width, 1, volume.pixels.along_rows + first, volume.sums_of_rows},
                   kept.rows, axes.rows);
    set_half_paths(volume,
                   {width, rows, 1, width, volume.pixels.along_columns + first, volume.sums_of_columns},
                   kept.columns, axes.columns);
    axes.small_step = step::small_step<std::uint32_t>(p1);
    const auto blocks = [](int paths) {
        return static_cast<unsigned>(blocks_for(static_cast<std::size_t>(paths) * kGroup, kBlock));
    };
    axes.row_blocks = blocks(rows);
    const dim3 grid(axes.row_blocks + blocks(width), 2);
    const bool wholly = matching::is_searched_wholly(volume.range);
    const auto inwards =
        wholly ? walk_inwards_kernel<matching::kLongRun> : walk_inwards_kernel<matching::kShortRun>;
    const auto outwards =
        wholly ? walk_outwards_kernel<matching::kLongRun> : walk_outwards_kernel<matching::kShortRun>;
    launch("walking paths inwards", stream, {grid, kBlock}, inwards, axes);
    launch("walking paths outwards", stream, {grid, kBlock}, outwards, axes);
}

}  // namespace hexrelief::cuda
