#include <algorithm>

#include "cuda/common/relaxed.cuh"
#include "cuda/matching/common/pixels.cuh"
#include "cuda/matching/refine/remove_speckles.h"
#include "pipeline/matching/refine/consistency_step.h"

// Speckles are found by union-find: a pixel's label is itself or a lower pixel of the same connected
// component. The order of joins differs from run to run, the components do not.
namespace hexrelief::cuda {
namespace {

constexpr unsigned kAllLanes = 0xffffffffu;
constexpr int kBlock = 128;
constexpr std::uint32_t kNone = 0xffffffffu;

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
        a = before;  // another thread labelled the root first; that label has to be joined with b
    }
}

__device__ std::uint32_t pixel_number(const matching::DisparityView& map, int x, int y) {
    return static_cast<std::uint32_t>(y) * static_cast<std::uint32_t>(map.width) +
           static_cast<std::uint32_t>(x);
}

// Returns, of 32 pixels of a row, those that have to join the pixels above, a bit each. A pixel is left out
// if its left neighbour is joined in the same way, as one join is enough for both. begins, begins_above:
// pixels that are not joined with their left neighbours.
__device__ unsigned joining_above(unsigned joined_above, unsigned begins, unsigned begins_above) {
    return joined_above & ~(joined_above << 1 & ~begins & ~begins_above);
}

// Labels each tile by itself. A pixel's label becomes the tile's first pixel of its component; that pixel
// gets as size the number of the component's pixels in the tile, the others 0. A warp handles a row of the
// tile at a time.
constexpr int kTile_px = 32, kWarps = 8, kRowsOfWarp = kTile_px / kWarps;

__global__ void label_tiles(matching::DisparityView map, int largest_step, SpeckleArrays arrays) {
    begin_kernel();
    __shared__ std::uint32_t labels[kTile_px * kTile_px], sizes[kTile_px * kTile_px];
    __shared__ unsigned beginnings[kTile_px];
    const unsigned lane = threadIdx.x;
    const int first_x = static_cast<int>(blockIdx.x) * kTile_px, x = first_x + static_cast<int>(lane),
              first_y = static_cast<int>(blockIdx.y) * kTile_px;
    const auto row_of = [&](int k) { return static_cast<int>(threadIdx.y) * kRowsOfWarp + k; };
    // heads: the run's first place; above: joined with the row above
    unsigned heads[kRowsOfWarp], above[kRowsOfWarp];
    unsigned known = 0;  // rows in which this lane's pixel is known, a bit each
#pragma unroll
    for (int k = 0; k < kRowsOfWarp; ++k) {
        const int row = row_of(k), y = first_y + row;
        const bool inside = x < map.width && y < map.height;
        const std::int16_t own = inside ? map.at(x, y) : matching::kUnknown16;
        const bool begins =
            lane == 0 || own == matching::kUnknown16 || !step::joined(own, map.at(x - 1, y), largest_step);
        const unsigned begin = __ballot_sync(kAllLanes, begins);
        above[k] = __ballot_sync(kAllLanes, own != matching::kUnknown16 && row > 0 &&
                                                step::joined(own, map.at(x, y - 1), largest_step));
        heads[k] = static_cast<unsigned>(row) * kTile_px + 31 -
                   __clz(static_cast<int>(begin & (kAllLanes >> (31 - lane))));
        known |= static_cast<unsigned>(own != matching::kUnknown16) << k;
        const unsigned place = static_cast<unsigned>(row) * kTile_px + lane;
        labels[place] = heads[k];
        sizes[place] = 0;
        if (lane == 0) beginnings[row] = begin;
    }
    __syncthreads();
#pragma unroll
    for (int k = 0; k < kRowsOfWarp; ++k) {
        const int row = row_of(k);
        const unsigned place = static_cast<unsigned>(row) * kTile_px + lane;
        if (row > 0 && joining_above(above[k], beginnings[row], beginnings[row - 1]) >> lane & 1u)
            join(labels, heads[k], place - kTile_px);
    }
    __syncthreads();
#pragma unroll
    for (int k = 0; k < kRowsOfWarp; ++k) {
        const int row = row_of(k);
        const unsigned place = static_cast<unsigned>(row) * kTile_px + lane;
        if (heads[k] != place || !(known >> k & 1u)) continue;
        const unsigned behind = lane == 31 ? 0 : beginnings[row] & (kAllLanes << (lane + 1));
        const unsigned root = find_root(labels, place);
        atomicAdd(&sizes[root], (behind ? __ffs(static_cast<int>(behind)) - 1 : 32) - lane);
        atomicExch(labels + place, root);
    }
    __syncthreads();
#pragma unroll
    for (int k = 0; k < kRowsOfWarp; ++k) {
        const int row = row_of(k), y = first_y + row;
        if (x >= map.width || y >= map.height) continue;
        const std::uint32_t pixel = pixel_number(map, x, y), root = labels[heads[k]];
        arrays.labels[pixel] = pixel_number(map, first_x + static_cast<int>(root % kTile_px),
                                            first_y + static_cast<int>(root / kTile_px));
        arrays.sizes[pixel] = sizes[static_cast<unsigned>(row) * kTile_px + lane];
    }
}

// A thread handles a pixel at the left side of a tile or, if blockIdx.y is 1, one at its upper side.
__global__ void join_tiles(matching::DisparityView map, int largest_step, SpeckleArrays arrays) {
    begin_kernel();
    const int number = static_cast<int>(blockIdx.x * blockDim.x + threadIdx.x);
    const bool is_left = blockIdx.y == 0;
    const int along = is_left ? map.height : map.width;
    const int across = (number / along + 1) * kTile_px;
    const int x = is_left ? across : number % along, y = is_left ? number % along : across;
    if (x >= map.width || y >= map.height) return;
    const std::uint32_t pixel = pixel_number(map, x, y);
    if (is_left) {
        if (step::joined(map.at(x, y), map.at(x - 1, y), largest_step)) join(arrays.labels, pixel, pixel - 1);
    } else if (step::joined(map.at(x, y), map.at(x, y - 1), largest_step)) {
        join(arrays.labels, pixel, pixel - static_cast<std::uint32_t>(map.width));
    }
}

// Adds up the components' sizes over the tiles, until they exceed the largest speckle. Afterwards the label
// of a tile's first pixel of a component is that of the component.
__global__ void count_pixels(matching::DisparityView map, unsigned largest, SpeckleArrays arrays) {
    begin_kernel();
    const int x = static_cast<int>(blockIdx.x * 32 + threadIdx.x);
    std::uint32_t large = kNone;  // a component that is known to be large
    for (int k = 0; k < kRowsOfWarp; ++k) {
        const int y = static_cast<int>(blockIdx.y * 8 + threadIdx.y) * kRowsOfWarp + k;
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

__global__ void clear_small(matching::DisparityOut map, matching::ConsistencyConfig config,
                            SpeckleArrays arrays) {
    begin_kernel();
    const int2 at = pixel_of_thread();
    if (at.x >= map.width || at.y >= map.height) return;
    const std::size_t pixel = static_cast<std::size_t>(at.y) * map.width + at.x;
    std::int16_t& own = map.at(at.x, at.y);
    if (own != matching::kUnknown16 && arrays.sizes[arrays.labels[arrays.labels[pixel]]] <=
                                           static_cast<unsigned>(step::largest_speckle(config, own)))
        own = matching::kUnknown16;
}

}  // namespace

void remove_speckles(cudaStream_t stream, const matching::ConsistencyConfig& config,
                     const SpeckleArrays& arrays, const matching::DisparityOut& map) {
    const Blocks blocks = pixel_blocks(map.width, map.height);
    const auto largest = static_cast<unsigned>(step::kFarSpeckles * config.speckle_pixels);
    const dim3 tiles(static_cast<unsigned>((map.width + kTile_px - 1) / kTile_px),
                     static_cast<unsigned>((map.height + kTile_px - 1) / kTile_px));
    launch("finding speckles", stream, {tiles, blocks.block}, label_tiles, reading(map), config.speckle_step,
           arrays);
    const std::size_t borders = std::max(static_cast<std::size_t>(tiles.x) * map.height,
                                         static_cast<std::size_t>(tiles.y) * map.width);
    launch("finding speckles", stream, {dim3(static_cast<unsigned>(blocks_for(borders, kBlock)), 2), kBlock},
           join_tiles, reading(map), config.speckle_step, arrays);
    launch("finding speckles", stream, pixel_blocks(map.width, (map.height + kRowsOfWarp - 1) / kRowsOfWarp),
           count_pixels, reading(map), largest, arrays);
    launch("removing speckles", stream, blocks, clear_small, map, config, arrays);
}

}  // namespace hexrelief::cuda
