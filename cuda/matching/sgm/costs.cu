#include "cuda/matching/common/pixels.cuh"
#include "cuda/matching/sgm/costs.h"
#include "pipeline/matching/sgm/cost_step.h"

namespace hexrelief::cuda {
namespace {

constexpr int kWarps = 8;

// A warp takes a pixel at a time, a lane every 32nd disparity.
template <int kChannels>
__global__ void __launch_bounds__(32 * kWarps)
    find_costs_kernel(PackedColors left, PackedColors right, RasterView<const std::uint64_t> left_census,
                      RasterView<const std::uint64_t> right_census, int min_px, DeviceVolume volume) {
    const int lane = static_cast<int>(threadIdx.x % 32), y = volume.rows.first + static_cast<int>(blockIdx.y);
    const int width = volume.width, warps = static_cast<int>(gridDim.x) * kWarps;
    const std::uint32_t* const right_row = right.row(y);
    const std::uint64_t* const right_census_row = right_census.row(y);
    for (int x = static_cast<int>(blockIdx.x) * kWarps + static_cast<int>(threadIdx.x / 32); x < width;
         x += warps) {
        const std::uint32_t own = left.at(x, y);
        const std::uint64_t own_census = left_census.at(x, y);
        std::uint8_t* const out =
            volume.costs + (static_cast<std::size_t>(blockIdx.y) * width + x) * volume.pitch;
        for (int d = lane; d < volume.count; d += 32) {
            const int column = clamped(x - min_px - d, width);
            const auto hamming =
                static_cast<std::uint8_t>(__popcll(own_census ^ __ldg(right_census_row + column)));
            const std::uint32_t other = __ldg(right_row + column);
            unsigned differences = 0;
#pragma unroll
            for (int c = 0; c < kChannels; ++c)
                differences += step::cut_difference(channel_of(own, c), channel_of(other, c));
            out[d] = step::matching_cost(hamming, static_cast<std::uint8_t>(differences), kChannels);
        }
    }
}

}  // namespace

void find_costs(cudaStream_t stream, const PairArrays& pair, int min_px, const DeviceVolume& volume) {
    constexpr int kPixels_a_warp = 8;
    const dim3 grid(static_cast<unsigned>(blocks_for(volume.width, kWarps * kPixels_a_warp)),
                    static_cast<unsigned>(volume.rows.count()));
    const auto kernel = pair.channels == 3 ? find_costs_kernel<3> : find_costs_kernel<1>;
    kernel<<<grid, 32 * kWarps, 0, stream>>>(reading(pair.colors[0]), reading(pair.colors[1]),
                                             reading(pair.census[0]), reading(pair.census[1]), min_px,
                                             volume);
    check_launch("finding matching costs");
}

}  // namespace hexrelief::cuda
