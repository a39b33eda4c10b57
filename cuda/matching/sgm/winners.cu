#include "cuda/matching/common/pixels.cuh"
#include "cuda/matching/sgm/winners.h"
#include "pipeline/matching/sgm/winner_step.h"

namespace hexrelief::cuda {
namespace {

// along: pixels from one disparity to the next where the sums beside the winner's lie, 0 in the left view, 1
// in the right one, whose pixels' costs are those of the left pixels that they match.
__device__ std::int16_t winner(const DeviceVolume& volume, std::uint32_t key, int x, int row, int along) {
    if (key >= kNoMatchKey) return kUnknown16;
    const int d = step::winner_disparity(key);
    const bool inside = d > 0 && d + 1 < volume.count && x - along >= 0 && x + along < volume.width;
    if (!inside) return static_cast<std::int16_t>(kOnePixel * d);
    const auto sum = [&](int step) {
        const std::size_t pixel = static_cast<std::size_t>(row) * volume.width + x + step * along;
        return volume.sums[pixel * volume.pitch + volume.entry(d + step)];
    };
    return static_cast<std::int16_t>(step::refined_winner(d, sum(-1), step::winner_sum(key), sum(1)));
}

__global__ void find_winners_kernel(DeviceVolume volume, WinnerKeys keys, int min_px,
                                    RasterView<std::int16_t> left, RasterView<std::int16_t> right) {
    const int2 at = pixel_of_thread();
    if (at.x >= volume.width || at.y >= volume.band.kept.count()) return;
    const std::size_t i = static_cast<std::size_t>(at.y) * volume.width + at.x;
    const int y = volume.band.kept.first + at.y;
    left.at(at.x, y) = winner(volume, keys.left[i], at.x, at.y, 0);
    const std::uint32_t key = keys.right[i];
    right.at(at.x, y) = winner(volume, key, at.x + min_px + step::winner_disparity(key), at.y, 1);
}

}  // namespace

void find_winners(cudaStream_t stream, const DeviceVolume& volume, const WinnerKeys& keys, int min_px,
                  const RasterView<std::int16_t>& left, const RasterView<std::int16_t>& right) {
    find_winners_kernel<<<pixel_grid(volume.width, volume.band.kept.count()), pixel_block(), 0, stream>>>(
        volume, keys, min_px, left, right);
    check_launch("finding winners");
}

}  // namespace hexrelief::cuda
