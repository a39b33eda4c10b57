#include "cuda/matching/sgm/paths.h"

#include "cuda/matching/sgm/walk_left.cuh"

namespace hexrelief::cuda {
namespace {

constexpr int kBlock = 64;

__device__ unsigned thread_of_grid() {
    return blockIdx.x * kBlock + threadIdx.x;
}

// The first direction: from step -lead on.
template <typename Shape>
__global__ void __launch_bounds__(kBlock) walk_forth_kernel(const Paths paths, int lead, int steps) {
    constexpr int kSteps = kSegment<Shape::kPer>;
    const LanePath<Shape> path(paths, thread_of_grid());
    PathCosts<Shape> costs;
    costs.begin(path.range, path.p1);
    walk<false>(path, -lead, lead, costs);
    const int last = (steps - 1) / kSteps;
    Segment<Shape> next = {};
    if (last > 0) next.read(path, 0);
    for (int number = 0; number < last; ++number) {
        const Segment<Shape> here = next;
        if (number + 1 < last) next.read(path, number + 1);
        if (path.exists) path.reader.keep(number, costs.pairs);
#pragma unroll
        for (int k = 0; k < kSteps; ++k) costs.advance(here.costs[k], path.p1, here.penalties[k], path.range);
    }
    if (path.exists) path.reader.keep(last, costs.pairs);
}

// The second direction on the way up: through steps end - 1 .. 0. Before these come `trail` steps from the
// path's end on; or the costs at the step walked last are read, where goes_on.
struct WayUp {
    int end, trail;
    bool goes_on;
    std::uint16_t* costs_here;  // pitch entries a path
};

// A warp walks both directions, as there are many columns.
template <typename Shape>
__global__ void __launch_bounds__(kBlock) walk_up_kernel(const Paths paths, const WayUp way) {
    constexpr int kSteps = kSegment<Shape::kPer>;
    const LanePath<Shape> path(paths, thread_of_grid());
    const LaneRange<Shape>& range = path.range;
    std::uint16_t* const costs_here =
        way.costs_here + static_cast<std::size_t>(path.number) * paths.pitch + range.first();
    PathCosts<Shape> back;
    if (way.goes_on) {
        typename Shape::Pairs pairs = {};
        if (range.any) load_words<Shape::kPairs>(costs_here, pairs);
        back.load(pairs, range);
    } else {
        back.begin(range, path.p1);
        walk<true>(path, way.end, way.trail, back);
    }
    const auto walk_both = [&](auto whole, const Segment<Shape>& segment, int number, int steps) {
        typename Shape::Pairs sums[kSteps];
        segment.template walk_forth<whole.value>(path, steps, sums);
#pragma unroll
        for (int k = kSteps - 1; k >= 0; --k) {
            if (!whole.value && k >= steps) continue;
            segment.step_back(path, k, back);
            add_costs<Shape>(back.pairs, path.p1, sums[k]);
            if (path.exists) path.reader.write_sums(number * kSteps + k, sums[k]);
        }
    };
    walk_segments_back<Shape>(
        way.end,
        [&](Segment<Shape>& segment, int number, int steps) { segment.read_with_start(path, number, steps); },
        walk_both);
    if (range.any && path.exists) store_words<Shape::kPairs>(back.pairs, costs_here);
}

// Calls launch(PathShape) with the one for so many disparities.
template <int kGroup, typename Launch>
void with_small_shape(int count, const Launch& launch) {
    constexpr int kPer = 8;
    if (count % kPer == 0)
        launch(PathShape<kGroup, kPer, false>{});
    else
        launch(PathShape<kGroup, kPer, true>{});
}
template <typename Launch>
void with_shape(int count, const Launch& launch) {
    if (count <= 64) return with_small_shape<8>(count, launch);
    if (count <= 128) return with_small_shape<16>(count, launch);
    if (count <= 256) return with_small_shape<32>(count, launch);
    if (count <= 512) return launch(PathShape<32, 16, true>{});
    if (count <= 1024) return launch(PathShape<32, 32, true>{});
    launch(PathShape<32, 64, true>{});
}

std::ptrdiff_t pixel(const DeviceVolume& volume, int x, int y) {
    return static_cast<std::ptrdiff_t>(y) * volume.width + x;
}

Paths paths_of(const PathInput& input, std::uint16_t* before_segments) {
    const DeviceVolume& volume = input.volume;
    Paths paths{};
    paths.costs = volume.costs;
    paths.sums = volume.sums;
    paths.costs_from = pixel(volume, 0, volume.band.rows.first);
    paths.sums_from = pixel(volume, 0, volume.band.kept.first);
    paths.disparities = volume.count;
    paths.pitch = volume.pitch;
    paths.p1 = step::pair_of(static_cast<std::uint32_t>(input.p1));
    paths.before_segments = before_segments;
    return paths;
}
Paths columns_of(const PathInput& input, int first_row, std::uint16_t* before_segments) {
    Paths paths = paths_of(input, before_segments);
    paths.count = paths.next_step = paths.kept_next_segment = input.volume.width;
    paths.first = pixel(input.volume, 0, first_row);
    paths.next_path = paths.kept_next_path = 1;
    paths.penalties = input.pair.penalty_y;
    return paths;
}
Paths rows_of(const PathInput& input, const Rows& rows, std::uint16_t* before_segments) {
    const DeviceVolume& volume = input.volume;
    Paths paths = paths_of(input, before_segments);
    paths.count = rows.count();
    paths.first = pixel(volume, 0, rows.first);
    paths.next_path = volume.width;
    paths.next_step = paths.kept_next_segment = 1;
    paths.kept_next_path = blocks_for(volume.width, segment_steps(volume.count));
    paths.penalties = input.pair.penalty_x;
    return paths;
}
template <typename Shape>
int blocks_of(const Paths& paths, Shape, int threads = kBlock) {
    return blocks_for(static_cast<std::size_t>(paths.count) * Shape::kGroup, threads);
}

}  // namespace

int disparities_a_lane(int count) {
    int per = 0;
    with_shape(count, [&](auto shape) { per = decltype(shape)::kPer; });
    return per;
}

int segment_steps(int count) {
    int steps = 0;
    with_shape(count, [&](auto shape) { steps = kSegment<decltype(shape)::kPer>; });
    return steps;
}

void walk_down(cudaStream_t stream, const PathInput& input, const Band& band,
               std::uint16_t* before_segments) {
    const Paths paths = columns_of(input, band.kept.first, before_segments);
    with_shape(input.volume.count, [&](auto shape) {
        walk_forth_kernel<decltype(shape)><<<blocks_of(paths, shape), kBlock, 0, stream>>>(
            paths, band.kept.first - band.rows.first, band.kept.count());
    });
    check_launch("walking paths down");
}

void walk_up(cudaStream_t stream, const PathInput& input, const Band& band, const Rows& rows,
             std::uint16_t* before_segments, std::uint16_t* costs_here) {
    const Paths paths = columns_of(input, rows.first, before_segments);
    const WayUp way{rows.count(), band.rows.end - rows.end, rows.end < band.kept.end, costs_here};
    with_shape(input.volume.count, [&](auto shape) {
        walk_up_kernel<decltype(shape)><<<blocks_of(paths, shape), kBlock, 0, stream>>>(paths, way);
    });
    check_launch("walking paths up");
}

void walk_right(cudaStream_t stream, const PathInput& input, const Rows& rows,
                std::uint16_t* before_segments) {
    const Paths paths = rows_of(input, rows, before_segments);
    with_shape(input.volume.count, [&](auto shape) {
        walk_forth_kernel<decltype(shape)>
            <<<blocks_of(paths, shape), kBlock, 0, stream>>>(paths, 0, input.volume.width);
    });
    check_launch("walking paths to the right");
}

void walk_left(cudaStream_t stream, const PathInput& input, std::uint16_t* before_segments) {
    const DeviceVolume& volume = input.volume;
    const std::size_t pixels = static_cast<std::size_t>(volume.width) * volume.band.kept.count();
    check(cudaMemsetAsync(input.keys.right, 0xff, pixels * sizeof(std::uint32_t), stream),
          "clearing winners");
    const Paths paths = rows_of(input, volume.band.kept, before_segments);
    const KeyRows rows{input.keys, input.min_px, volume.width};
    with_shape(volume.count, [&](auto shape) {
        walk_left_kernel<decltype(shape)>
            <<<blocks_of(paths, shape, kWarp), 2 * kWarp, 0, stream>>>(paths, volume.width, rows);
    });
    check_launch("walking paths to the left");
}

}  // namespace hexrelief::cuda
