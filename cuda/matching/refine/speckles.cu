#include "cuda/common/relaxed.cuh"
#include "cuda/matching/common/pixels.cuh"
#include "cuda/matching/refine/speckles.h"
#include "pipeline/matching/refine/consistency_step.h"

// Union-find: a pixel's label is a pixel of the same patch with a smaller number, or itself. What is joined
// first differs from run to run, the patches do not.
namespace hexrelief::cuda {
namespace {

constexpr unsigned kAllLanes = 0xffffffffu;
constexpr std::uint32_t kNone = 0xffffffffu;
constexpr int kRowsOfThread = 4;

__device__ std::uint32_t find_root(const std::uint32_t* labels, std::uint32_t pixel) {
    for (;;) {
        const std::uint32_t label = load_relaxed(labels + pixel);
        if (label == pixel) return pixel;
        pixel = label;
    }
}

__device__ void join(std::uint32_t* labels, std::uint32_t a, std::uint32_t b) {
    for (;;) {
        a = find_root(labels, a);
        b = find_root(labels, b);
        if (a == b) return;
        if (a < b) {
            const std::uint32_t larger = b;
            b = a;
            a = larger;
        }
        const std::uint32_t before = atomicMin(labels + a, b);
        if (before == a) return;
        a = before;  // someone else gave the root a label first, which b has to be joined with
    }
}

__device__ std::uint32_t pixel_number(const DisparityView& map, int x, int y) {
    return static_cast<std::uint32_t>(y) * static_cast<std::uint32_t>(map.width) +
           static_cast<std::uint32_t>(x);
}

// A warp's pixels get the first one of their run as label; that one gets the run's length as size, the others
// 0.
__global__ void label_runs(DisparityView map, int largest_step, SpeckleArrays arrays) {
    const int2 at = pixel_of_thread();
    const bool inside = at.x < map.width && at.y < map.height;
    const unsigned lane = threadIdx.x;
    const std::int16_t own = inside ? map.at(at.x, at.y) : kUnknown16;
    const bool begins = lane == 0 || !inside || !step::joined(own, map.at(at.x - 1, at.y), largest_step);
    const unsigned beginnings = __ballot_sync(kAllLanes, begins);
    if (!inside) return;
    const unsigned first = 31 - __clz(static_cast<int>(beginnings & (kAllLanes >> (31 - lane))));
    const unsigned behind = lane == 31 ? 0 : beginnings & (kAllLanes << (lane + 1));
    const std::uint32_t pixel = pixel_number(map, at.x, at.y);
    arrays.labels[pixel] = pixel - (lane - first);
    arrays.sizes[pixel] =
        begins && own != kUnknown16 ? (behind ? __ffs(static_cast<int>(behind)) - 1 : 32) - lane : 0;
}

__global__ void join_runs(DisparityView map, int largest_step, SpeckleArrays arrays) {
    const int2 at = pixel_of_thread();
    if (at.x >= map.width || at.y >= map.height) return;
    const std::int16_t own = map.at(at.x, at.y), left = map.at(at.x - 1, at.y),
                       above = map.at(at.x, at.y - 1), above_left = map.at(at.x - 1, at.y - 1);
    const std::uint32_t pixel = pixel_number(map, at.x, at.y);
    const bool to_left = step::joined(own, left, largest_step);
    if (to_left && threadIdx.x == 0) join(arrays.labels, pixel, pixel - 1);
    if (!step::joined(own, above, largest_step)) return;
    // Where the pixels to the left are joined in the same way, that is enough for both.
    const bool known = to_left && step::joined(left, above_left, largest_step) &&
                       step::joined(above, above_left, largest_step);
    if (!known) join(arrays.labels, pixel, pixel - static_cast<std::uint32_t>(map.width));
}

// Adds the runs' sizes to those of their patches, until a patch is larger than a speckle may be. Afterwards
// the label of a run's first pixel is that of its patch.
__global__ void count_runs(DisparityView map, unsigned largest, SpeckleArrays arrays) {
    const int x = static_cast<int>(blockIdx.x * 32 + threadIdx.x);
    std::uint32_t large = kNone;  // a patch that is known to be large: most runs belong to few patches
    for (int k = 0; k < kRowsOfThread; ++k) {
        const int y = static_cast<int>(blockIdx.y * 8 + threadIdx.y) * kRowsOfThread + k;
        if (x >= map.width || y >= map.height) return;
        const std::uint32_t pixel = pixel_number(map, x, y), size = load_relaxed(arrays.sizes + pixel);
        if (size == 0) continue;
        const std::uint32_t root = find_root(arrays.labels, pixel);
        if (root == pixel) continue;
        store_relaxed(arrays.labels + pixel, root);
        if (root == large) continue;
        if (load_relaxed(arrays.sizes + root) > largest)
            large = root;
        else
            atomicAdd(arrays.sizes + root, size);
    }
}

__global__ void clear_small(DisparityOut map, unsigned largest, SpeckleArrays arrays) {
    const int2 at = pixel_of_thread();
    if (at.x >= map.width || at.y >= map.height) return;
    const std::size_t pixel = static_cast<std::size_t>(at.y) * map.width + at.x;
    std::int16_t& own = map.at(at.x, at.y);
    if (own != kUnknown16 && arrays.sizes[arrays.labels[arrays.labels[pixel]]] <= largest) own = kUnknown16;
}

}  // namespace

void remove_speckles(cudaStream_t stream, const ConsistencyConfig& config, const SpeckleArrays& arrays,
                     const DisparityOut& map) {
    const dim3 grid = pixel_grid(map.width, map.height), block = pixel_block();
    const auto largest = static_cast<unsigned>(config.speckle_pixels);
    label_runs<<<grid, block, 0, stream>>>(reading(map), config.speckle_step, arrays);
    check_launch("finding speckles");
    join_runs<<<grid, block, 0, stream>>>(reading(map), config.speckle_step, arrays);
    check_launch("finding speckles");
    count_runs<<<pixel_grid(map.width, (map.height + kRowsOfThread - 1) / kRowsOfThread), block, 0, stream>>>(
        reading(map), largest, arrays);
    check_launch("finding speckles");
    clear_small<<<grid, block, 0, stream>>>(map, largest, arrays);
    check_launch("removing speckles");
}

}  // namespace hexrelief::cuda
