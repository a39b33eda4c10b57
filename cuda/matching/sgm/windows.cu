#include "cuda/matching/common/pixels.cuh"
#include "cuda/matching/sgm/windows.h"
#include "pipeline/matching/sgm/window_step.h"

namespace hexrelief::cuda {
namespace {

__global__ void find_windows_kernel(DisparityView half, int half_min_px, DisparityRange range,
                                    RasterView<SearchWindow> windows) {
    const int2 at = pixel_of_thread();
    if (at.x >= windows.width || at.y >= windows.height) return;
    windows.at(at.x, at.y) =
        range.count <= kSearched ? kWholeWindow : step::find_window(half, half_min_px, range, at.x, at.y);
}

}  // namespace

void find_windows(cudaStream_t stream, const RasterView<std::int16_t>& half, const DisparityRange& range,
                  const RasterView<SearchWindow>& windows) {
    find_windows_kernel<<<pixel_grid(windows.width, windows.height), pixel_block(), 0, stream>>>(
        reading(half), at_half_size(range).min_px, range, windows);
    check_launch("finding search windows");
}

}  // namespace hexrelief::cuda
