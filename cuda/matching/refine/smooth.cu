#include "cuda/matching/common/pixels.cuh"
#include "cuda/matching/refine/record_access.cuh"
#include "cuda/matching/refine/smooth.h"
#include "pipeline/matching/refine/smooth_step.h"

namespace hexrelief::cuda {
namespace {

// A pixel that is smoothed. It takes two opposite pixels of its window at a time, in the two halves of words.
class SmoothedPixel {
  public:
    __device__ explicit SmoothedPixel(const PlaneRecord& own)
        : own_(own), color_(own.color), own_less_reach_(own.disparity - step::kSmoothReach) {}

    // Adds pixel a, (a_dx, a_dy) px away, and pixel b. kernel: step::smoothing_kernel() of both.
    __device__ void add(const PlaneRecord& a, int a_dx, int a_dy, const PlaneRecord& b, int b_dx, int b_dy,
                        unsigned kernel) {
        // step::off_plane() + step::kSmoothReach
        const auto off = [&](const PlaneRecord& other, int steps) {
            const int change = plane_change(own_.slopes, steps, plane_change(other.slopes, steps));
            return static_cast<unsigned>(step::off_plane(own_less_reach_, other.disparity, change));
        };
        const std::uint32_t offs =
            __byte_perm(off(a, packed_steps(a_dx, a_dy)), off(b, packed_steps(b_dx, b_dy)), 0x5410);
        std::uint32_t near = step::nearness(offs);
        if (color_.unlike(a.color)) near &= 0xffff0000u;
        if (color_.unlike(b.color)) near &= 0x0000ffffu;
        sums_.add(kernel, near, offs);
    }
    __device__ std::int16_t disparity() const {
        // the pixel itself lies on its plane
        constexpr int kMiddle = step::smoothing_kernel<int>(0, 0) * step::kSmoothReach;
        const int weights = kMiddle + static_cast<int>((sums_.weights & 0xffffu) + (sums_.weights >> 16));
        return step::smoothed(static_cast<std::int16_t>(own_.disparity),
                              sums_.offs + kMiddle * step::kSmoothReach, weights);
    }

  private:
    const PlaneRecord& own_;
    step::PlaneColor color_;
    int own_less_reach_;
    step::SmoothSums<std::uint32_t> sums_;
};

__device__ void write_smoothed(const PlaneRecord& own, std::int16_t disparity, PlaneRecord* to) {
    write_record({disparity, own.slopes, own.color, 0}, to);
}
__device__ void write_smoothed(const PlaneRecord&, std::int16_t disparity, std::int16_t* to) {
    *to = disparity;
}

// A thread handles a pixel and the one kStride px below it, whose windows of 5x5 pixels, kStride px
// apart, share most rows.
template <int kStride, typename Out>
__global__ void smooth_kernel(PlaneRecords records, matching::RasterView<Out> out) {
    begin_kernel();
    constexpr int kRadius = step::kSmoothRadius, kRows = 2 * kRadius + 2;
    const auto kernel = [](int i, int j) { return step::smoothing_kernel<unsigned>(i, j); };
    const int2 thread = pixel_of_thread();
    const int x = thread.x, y = thread.y / kStride * (2 * kStride) + thread.y % kStride;
    if (x >= records.width || y >= records.height) return;
    const auto record = [&](int i, int j) {
        return read_record(&records.at(x + i * kStride, y + j * kStride));
    };
    PlaneRecord column[kRows];  // from j = -kRadius on
#pragma unroll
    for (int j = 0; j < kRows; ++j) column[j] = record(0, j - kRadius);
    SmoothedPixel pixels[2] = {SmoothedPixel(column[kRadius]), SmoothedPixel(column[kRadius + 1])};
#pragma unroll
    for (int row = -kRadius; row <= kRadius + 1; ++row)
#pragma unroll
        for (int i = 1; i <= kRadius; ++i) {
            const PlaneRecord right = record(i, row), left = record(-i, row);
#pragma unroll
            for (int p = 0; p < 2; ++p)
                if (const int j = row - p; j >= -kRadius && j <= kRadius)
                    pixels[p].add(right, i * kStride, j * kStride, left, -i * kStride, j * kStride,
                                  kernel(i, j));
        }
#pragma unroll
    for (int p = 0; p < 2; ++p) {
        const int own = kRadius + p;
#pragma unroll
        for (int j = 1; j <= kRadius; ++j)
            pixels[p].add(column[own - j], 0, -j * kStride, column[own + j], 0, j * kStride, kernel(0, j));
        if (y + p * kStride < records.height)
            write_smoothed(column[own], pixels[p].disparity(), &out.at(x, y + p * kStride));
    }
}

template <int kStride, typename Out>
void smooth(cudaStream_t stream, const PlaneRecords& records, const matching::RasterView<Out>& out) {
    const int rows = (records.height + 2 * kStride - 1) / (2 * kStride) * kStride;
    launch("smoothing", stream, pixel_blocks(records.width, rows), smooth_kernel<kStride, Out>, records, out);
}

}  // namespace

void smooth(cudaStream_t stream, const matching::RasterView<PlaneRecord>& records,
            const matching::RasterView<PlaneRecord>& others, const matching::DisparityOut& result) {
    static_assert(step::kSmoothLevels == 3);
    smooth<1>(stream, reading(records), others);
    smooth<2>(stream, reading(others), records);
    smooth<4>(stream, reading(records), result);
}

}  // namespace hexrelief::cuda
