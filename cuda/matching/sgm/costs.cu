#include "cuda/matching/common/pixels.cuh"
#include "cuda/matching/sgm/costs.h"
#include "pipeline/matching/sgm/cost_step.h"

namespace hexrelief::cuda {
namespace {

constexpr int kBlock = 128;
constexpr int kEntries = 8;  // of a lane, which follow each other: four pairs (see DeviceVolume)
constexpr int kPairs = kEntries / 2;
constexpr int kRun = 64;  // pixels that a lane takes one after the other

struct CostInput {
    PackedColors left, right;
    RasterView<const std::uint64_t> left_census, right_census;
    int min_px;
};

// A pixel, or some of the right picture's.
template <int kCount>
struct Pixels {
    std::uint64_t census[kCount];
    std::uint32_t colors[kCount];

    __device__ void take(int i, const std::uint64_t* census_row, const std::uint32_t* color_row, int column) {
        census[i] = __ldg(census_row + column);
        colors[i] = __ldg(color_row + column);
    }
};

// The costs of a pair of disparities, side by side.
template <int kChannels>
__device__ std::uint32_t costs_of_pair(const Pixels<1>& own, const Pixels<kEntries>& others, int low,
                                       int high) {
    const auto hamming = [&](int i) {
        return static_cast<std::uint32_t>(__popcll(own.census[0] ^ others.census[i]));
    };
    return step::matching_costs_of_pair(
        hamming(low) | hamming(high) << 16,
        step::cut_differences_of_pair(own.colors[0], others.colors[low], others.colors[high], kChannels),
        kChannels);
}

// What a lane has to do: some entries of each pixel of a run.
struct Run {
    const std::uint64_t *left_census, *right_census;  // of the row
    const std::uint32_t *left, *right;
    int width, first_x, pixels;
    int first_column;  // of the right picture, which matches the first pixel at the nearest disparity
    int farther;       // how far the farther disparity of a pair is from the nearer one
    std::uint8_t* out;
    int pitch;
};

// Of what a pixel is compared with, most columns are those of the pixel before: eight stay in registers,
// those of the nearer disparities of four pairs and those of the farther ones, and the oldest is replaced at
// each pixel. kContiguous: the farther disparities follow the nearer ones, so that what leaves these is what
// comes to those. kInside: no column lies outside of the right picture, whose edge counts there.
template <int kChannels, bool kContiguous, bool kInside>
__device__ void find_costs_of_run(const Run& run) {
    // Column number i of the nearer disparities is in slot i modulo eight, of the farther ones in the slot
    // after the next three.
    Pixels<kEntries> others;
    const auto take = [&](int slot, int column) {
        others.take(slot, run.right_census, run.right, kInside ? column : clamped(column, run.width));
    };
#pragma unroll
    for (int k = 1; k < kPairs; ++k) take(kEntries - k, run.first_column - k);
#pragma unroll
    for (int k = kContiguous ? 0 : 1; k < kPairs; ++k) take(kPairs - k, run.first_column - run.farther - k);
    std::uint8_t* out = run.out;
    for (int i = 0; i < run.pixels; i += kEntries) {
#pragma unroll
        for (int u = 0; u < kEntries; ++u) {
            if (i + u >= run.pixels) break;
            const int column = run.first_column + i + u;
            take(u, column);
            if (!kContiguous) take((u + kPairs) % kEntries, column - run.farther);
            Pixels<1> own;
            own.take(0, run.left_census, run.left, run.first_x + i + u);
            std::uint32_t pairs[kPairs];
#pragma unroll
            for (int k = 0; k < kPairs; ++k)
                pairs[k] = costs_of_pair<kChannels>(own, others, (u + kEntries - k) % kEntries,
                                                    (u + kPairs - k) % kEntries);
            *reinterpret_cast<uint2*>(out) =
                make_uint2(__byte_perm(pairs[0], pairs[1], 0x6420), __byte_perm(pairs[2], pairs[3], 0x6420));
            out += run.pitch;
        }
    }
}

// Some lanes take a run of pixels of a row. Entries up to the pitch are read later, so they are written, too.
template <int kChannels, bool kContiguous>
__global__ void __launch_bounds__(kBlock)
    find_costs_kernel(CostInput in, DeviceVolume volume, int lanes_a_pixel) {
    const int thread = static_cast<int>(blockIdx.x * kBlock + threadIdx.x);
    const int entry = (static_cast<int>(blockIdx.z) * lanes_a_pixel + thread % lanes_a_pixel) * kEntries;
    const int y = volume.band.rows.first + static_cast<int>(blockIdx.y);
    Run run{in.left_census.row(y), in.right_census.row(y), in.left.row(y), in.right.row(y), volume.width};
    run.first_x = thread / lanes_a_pixel * kRun;
    if (run.first_x >= run.width || entry >= volume.pitch) return;
    run.pixels = min(kRun, run.width - run.first_x);
    run.farther = volume.lane_count / 2;
    const int nearest = entry / volume.lane_count * volume.lane_count + entry % volume.lane_count / 2;
    run.first_column = run.first_x - in.min_px - nearest;
    run.pitch = volume.pitch;
    run.out =
        volume.costs + (static_cast<std::size_t>(blockIdx.y) * run.width + run.first_x) * run.pitch + entry;
    const int last_column = run.first_column + run.pixels - 1;
    if (run.first_column - run.farther - kPairs >= 0 && last_column < run.width)
        find_costs_of_run<kChannels, kContiguous, true>(run);
    else
        find_costs_of_run<kChannels, kContiguous, false>(run);
}

}  // namespace

void find_costs(cudaStream_t stream, const PairArrays& pair, int min_px, const DeviceVolume& volume) {
    const int lanes = blocks_for(volume.pitch, kEntries), lanes_a_pixel = lanes <= 8    ? 8
                                                                          : lanes <= 16 ? 16
                                                                                        : 32;
    const std::size_t runs = static_cast<std::size_t>(blocks_for(volume.width, kRun));
    const dim3 grid(static_cast<unsigned>(blocks_for(runs * lanes_a_pixel, kBlock)),
                    static_cast<unsigned>(volume.band.rows.count()),
                    static_cast<unsigned>(blocks_for(lanes, lanes_a_pixel)));
    const CostInput input{reading(pair.colors[0]), reading(pair.colors[1]), reading(pair.census[0]),
                          reading(pair.census[1]), min_px};
    const bool contiguous = volume.lane_count == kEntries;
    const auto kernel = pair.channels == 3
                            ? (contiguous ? find_costs_kernel<3, true> : find_costs_kernel<3, false>)
                            : (contiguous ? find_costs_kernel<1, true> : find_costs_kernel<1, false>);
    kernel<<<grid, kBlock, 0, stream>>>(input, volume, lanes_a_pixel);
    check_launch("finding matching costs");
}

}  // namespace hexrelief::cuda
