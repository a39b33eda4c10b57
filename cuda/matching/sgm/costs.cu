#include "cuda/matching/common/pixels.cuh"
#include "cuda/matching/sgm/costs.h"
#include "pipeline/matching/sgm/cost_step.h"

namespace hexrelief::cuda {
namespace {

constexpr int kWarps = 8;

struct CostInput {
    PackedColors left, right;
    RasterView<const std::uint64_t> left_census, right_census;
    int min_px;
};

template <int kChannels>
__device__ std::uint8_t cost_of(std::uint64_t own_census, std::uint32_t own, std::uint64_t other_census,
                                std::uint32_t other) {
    const auto hamming = static_cast<std::uint8_t>(__popcll(own_census ^ other_census));
    const std::uint8_t differences = kChannels == 3
                                         ? step::cut_differences(own, other)
                                         : step::cut_difference(channel_of(own, 0), channel_of(other, 0));
    return step::matching_cost(hamming, differences, kChannels);
}

// A warp takes a pixel at a time, a lane every 32nd disparity. Entries up to the pitch are read, so they are
// written, too.
template <int kChannels>
__global__ void __launch_bounds__(32 * kWarps) find_costs_kernel(CostInput in, DeviceVolume volume) {
    const int lane = static_cast<int>(threadIdx.x % 32),
              y = volume.band.rows.first + static_cast<int>(blockIdx.y);
    const int width = volume.width, count = volume.pitch, warps = static_cast<int>(gridDim.x) * kWarps;
    const std::uint32_t* const right = in.right.row(y);
    const std::uint64_t* const right_census = in.right_census.row(y);
    for (int x = static_cast<int>(blockIdx.x) * kWarps + static_cast<int>(threadIdx.x / 32); x < width;
         x += warps) {
        const std::uint32_t own = in.left.at(x, y);
        const std::uint64_t own_census = in.left_census.at(x, y);
        std::uint8_t* const out =
            volume.costs + (static_cast<std::size_t>(blockIdx.y) * width + x) * volume.pitch;
        const int first = x - in.min_px;  // the column that matches at the least disparity
        if (first < width && first >= count - 1) {
#pragma unroll 4
            for (int d = lane; d < count; d += 32)
                out[d] = cost_of<kChannels>(own_census, own, __ldg(right_census + first - d),
                                            __ldg(right + first - d));
        } else {  // some lie outside of the right picture, whose edge then counts
            for (int d = lane; d < count; d += 32) {
                const int column = clamped(first - d, width);
                out[d] =
                    cost_of<kChannels>(own_census, own, __ldg(right_census + column), __ldg(right + column));
            }
        }
    }
}

}  // namespace

void find_costs(cudaStream_t stream, const PairArrays& pair, int min_px, const DeviceVolume& volume) {
    constexpr int kPixels_a_warp = 8;
    const dim3 grid(static_cast<unsigned>(blocks_for(volume.width, kWarps * kPixels_a_warp)),
                    static_cast<unsigned>(volume.band.rows.count()));
    const CostInput input{reading(pair.colors[0]), reading(pair.colors[1]), reading(pair.census[0]),
                          reading(pair.census[1]), min_px};
    const auto kernel = pair.channels == 3 ? find_costs_kernel<3> : find_costs_kernel<1>;
    kernel<<<grid, 32 * kWarps, 0, stream>>>(input, volume);
    check_launch("finding matching costs");
}

}  // namespace hexrelief::cuda
