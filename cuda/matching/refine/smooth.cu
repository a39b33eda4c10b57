#include "cuda/matching/common/pixels.cuh"
#include "cuda/matching/refine/record_access.cuh"
#include "cuda/matching/refine/smooth.h"
#include "pipeline/matching/refine/smooth_step.h"

namespace hexrelief::cuda {
namespace {

// step::off_plane(), dot products of both slopes at once.
__device__ int off_plane(const PixelRecord& own, const PixelRecord& other, int dx, int dy) {
    const int steps = packed_steps(dx, dy),
              change = plane_change(other.slopes, steps, plane_change(own.slopes, steps, 16));
    return other.disparity - (change >> 5) - own.disparity;
}

// The disparity of a pixel, smoothed by 5x5 pixels kStride px apart; unknown ones are not alike.
template <int kStride>
__device__ std::int16_t smoothed_disparity(const PixelRecords& records, const PixelRecord& own, int x,
                                           int y) {
    int offs = 0, weights = 0;
#pragma unroll
    for (int j = -step::kSmoothRadius; j <= step::kSmoothRadius; ++j) {
        const PixelRecord* const row = records.row(y + j * kStride) + x;
#pragma unroll
        for (int i = -step::kSmoothRadius; i <= step::kSmoothRadius; ++i) {
            const PixelRecord other = read_record(row + i * kStride);
            const int off = off_plane(own, other, i * kStride, j * kStride);
            const bool alike = within_color_step(own.color, other.color, step::kSmoothColor);
            const int weight = step::smoothing_weight<int>(off, step::smoothing_kernel<int>(i, j), alike);
            offs += weight * off;
            weights += weight;
        }
    }
    return step::smoothed(own.disparity, offs, weights);
}

template <int kStride>
__global__ void smooth_records(PixelRecords records, RasterView<PixelRecord> out) {
    begin_kernel();
    const int2 at = pixel_of_thread();
    if (at.x >= records.width || at.y >= records.height) return;
    PixelRecord own = read_record(&records.at(at.x, at.y));
    own.disparity = smoothed_disparity<kStride>(records, own, at.x, at.y);
    write_record(own, &out.at(at.x, at.y));
}

template <int kStride>
__global__ void smooth_to_result(PixelRecords records, DisparityOut out) {
    begin_kernel();
    const int2 at = pixel_of_thread();
    if (at.x >= records.width || at.y >= records.height) return;
    const PixelRecord own = read_record(&records.at(at.x, at.y));
    out.at(at.x, at.y) = smoothed_disparity<kStride>(records, own, at.x, at.y);
}

}  // namespace

void smooth(cudaStream_t stream, const RasterView<PixelRecord>& records,
            const RasterView<PixelRecord>& others, const DisparityOut& result) {
    static_assert(step::kSmoothLevels == 3);
    const Blocks blocks = pixel_blocks(records.width, records.height);
    launch("smoothing", stream, blocks, smooth_records<1>, reading(records), others);
    launch("smoothing", stream, blocks, smooth_records<2>, reading(others), records);
    launch("smoothing", stream, blocks, smooth_to_result<4>, reading(records), result);
}

}  // namespace hexrelief::cuda
