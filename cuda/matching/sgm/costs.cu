#include "cuda/matching/common/pixels.cuh"
#include "cuda/matching/sgm/costs.h"
#include "cuda/matching/sgm/path_costs.cuh"
#include "pipeline/matching/sgm/cost_step.h"

namespace hexrelief::cuda {
namespace {

constexpr int kBlock = 128;
constexpr int kPixelsOfRun = 64;  // that a lane takes one after the other

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
__device__ std::uint32_t costs_of_pair(const Pixels<1>& own, const Pixels<kLaneEntries>& others, int low,
                                       int high) {
    const auto hamming = [&](int i) {
        return static_cast<std::uint32_t>(__popcll(own.census[0] ^ others.census[i]));
    };
    return step::matching_costs_of_pair(
        hamming(low) | hamming(high) << 16,
        step::cut_differences_of_pair(own.colors[0], others.colors[low], others.colors[high], kChannels),
        kChannels);
}

// What a lane has to do: its part of the window of each pixel of a run.
struct Run {
    const std::uint64_t *left_census, *right_census;  // of the row
    const std::uint32_t *left, *right;
    const SearchWindow* windows;
    int width, count, min_px;
    int first_x, end_x;
    std::uint8_t* out;
};

// Of what a pixel is compared with, most columns are those of the pixel before: as many as a lane has entries
// stay in registers, and the oldest is replaced at each pixel; where the window moves, all are.
template <int kChannels>
__device__ void find_costs_of_run(const Run& run) {
    // The column of the nearest disparity is in the slot of the step, those of farther ones in those before.
    Pixels<kLaneEntries> others;
    int part = -1;
    std::uint8_t* out = run.out;
    for (int first = run.first_x; first < run.end_x; first += kLaneEntries) {
#pragma unroll
        for (int u = 0; u < kLaneEntries; ++u) {
            const int x = first + u;
            if (x >= run.end_x) break;
            const int here = part_of_lane(packed(run.windows[x]), lane_of_group());
            const int disparity = here * kLaneEntries, column = x - run.min_px - disparity;
            const auto take = [&](int slot, int from) {
                others.take(slot, run.right_census, run.right, clamped(from, run.width));
            };
            take(u, column);
            if (here != part)
#pragma unroll
                for (int k = 1; k < kLaneEntries; ++k)
                    take((u + kLaneEntries - k) % kLaneEntries, column - k);
            part = here;
            Pixels<1> own;
            own.take(0, run.left_census, run.left, x);
            std::uint32_t pairs[kLanePairs];
#pragma unroll
            for (int k = 0; k < kLanePairs; ++k) {
                pairs[k] = costs_of_pair<kChannels>(own, others, (u + kLaneEntries - k) % kLaneEntries,
                                                    (u + kLanePairs - k + kLaneEntries) % kLaneEntries);
                if (disparity + kLaneEntries > run.count)
                    pairs[k] |= (disparity + k < run.count ? 0 : kBeyondRange) |
                                (disparity + k + kLanePairs < run.count ? 0 : kBeyondRange << 16);
            }
            *reinterpret_cast<uint2*>(out) =
                make_uint2(__byte_perm(pairs[0], pairs[1], 0x6420), __byte_perm(pairs[2], pairs[3], 0x6420));
            out += kSearched;
        }
    }
}

// A group of lanes takes a run of pixels of a row.
template <int kChannels>
__global__ void __launch_bounds__(kBlock) find_costs_kernel(CostInput in, DeviceVolume volume) {
    const int group = static_cast<int>(blockIdx.x * kBlock + threadIdx.x) / kGroup;
    const int y = volume.band.rows.first + static_cast<int>(blockIdx.y);
    Run run{in.left_census.row(y), in.right_census.row(y), in.left.row(y), in.right.row(y),
            volume.windows.row(y), volume.width,           volume.count,   in.min_px};
    run.first_x = group * kPixelsOfRun;
    if (run.first_x >= run.width) return;
    run.end_x = min(run.width, run.first_x + kPixelsOfRun);
    run.out = volume.costs + (static_cast<std::size_t>(blockIdx.y) * run.width + run.first_x) * kSearched +
              lane_of_group() * kLaneEntries;
    find_costs_of_run<kChannels>(run);
}

}  // namespace

void find_costs(cudaStream_t stream, const PairArrays& pair, int min_px, const DeviceVolume& volume) {
    const std::size_t runs = static_cast<std::size_t>(blocks_for(volume.width, kPixelsOfRun));
    const dim3 grid(static_cast<unsigned>(blocks_for(runs * kGroup, kBlock)),
                    static_cast<unsigned>(volume.band.rows.count()));
    const CostInput input{reading(pair.colors[0]), reading(pair.colors[1]), reading(pair.census[0]),
                          reading(pair.census[1]), min_px};
    const auto kernel = pair.channels == 3 ? find_costs_kernel<3> : find_costs_kernel<1>;
    kernel<<<grid, kBlock, 0, stream>>>(input, volume);
    check_launch("finding matching costs");
}

}  // namespace hexrelief::cuda
