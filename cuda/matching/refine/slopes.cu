#include "cuda/matching/common/pixels.cuh"
#include "cuda/matching/refine/record_access.cuh"
#include "cuda/matching/refine/slopes.h"
#include "pipeline/matching/refine/slope_step.h"
#include "pipeline/matching/refine/vote_step.h"

namespace hexrelief::cuda {
namespace {

// Of the pixels `along` entries apart.
__device__ int fitted_slope(const std::int16_t* pixel, std::ptrdiff_t along) {
    step::LineSums<int> sums;
    const int own = *pixel;
#pragma unroll
    for (int side = -1; side <= 1; side += 2) {
        int on = step::mask_of<int>(own >= 0), before = own;
#pragma unroll
        for (int k = 1; k <= step::kSamples; ++k) {
            const int here = pixel[side * k * along];
            on = step::run_reaches(on, here, before);
            step::add_sample(side < 0 ? sums.before : sums.behind, sums.v, sums.tv, side * k, here - own, on);
            before = here;
        }
    }
    return step::slope_of(sums);
}

// Both in one word, each larger by kSteepest, so that the sum of some words is that of both.
__device__ std::uint32_t packed_slopes(int x, int y) {
    return static_cast<std::uint32_t>(x + step::kSteepest) | static_cast<std::uint32_t>(y + step::kSteepest)
                                                                 << 16;
}

__global__ void fit_slopes(DisparityView map, FittedSlopes out) {
    const int2 at = pixel_of_thread();
    if (at.x >= map.width || at.y >= map.height) return;
    const std::int16_t* const pixel = &map.at(at.x, at.y);
    out.at(at.x, at.y) = packed_slopes(fitted_slope(pixel, 1), fitted_slope(pixel, map.stride));
}

// The mean of 3x3 pixels, channel by channel.
__device__ std::uint32_t blurred(const PackedColors& colors, int x, int y) {
    std::uint16_t sums[3] = {};
#pragma unroll
    for (int j = -1; j <= 1; ++j) {
        const std::uint32_t* const row = colors.row(clamped(y + j, colors.height));
#pragma unroll
        for (int i = -1; i <= 1; ++i) {
            const std::uint32_t color = row[clamped(x + i, colors.width)];
#pragma unroll
            for (int c = 0; c < 3; ++c) sums[c] = static_cast<std::uint16_t>(sums[c] + channel_of(color, c));
        }
    }
    std::uint32_t color = 0;
#pragma unroll
    for (int c = 0; c < 3; ++c) color |= std::uint32_t{step::rounded_ninth(sums[c])} << (8 * c);
    return color;
}

__device__ bool is_known_beside_unknown(const DisparityView& map, int x, int y) {
    bool unknown = false;
#pragma unroll
    for (int j = -1; j <= 1; ++j)
#pragma unroll
        for (int i = -1; i <= 1; ++i) unknown |= map.at(x + i, y + j) < 0;
    return unknown && map.at(x, y) >= 0;
}

__global__ void average_slopes(RecordInput in, RasterView<const std::uint32_t> fitted,
                               RasterView<PixelRecord> out) {
    const int2 at = pixel_of_thread();
    if (at.x >= in.map.width || at.y >= in.map.height) return;
    if (in.which == RecordsOf::beside_unknown && !is_known_beside_unknown(in.map, at.x, at.y)) return;
    const std::int16_t own = in.map.at(at.x, at.y);
    int count = 0;
    std::uint32_t sums = 0;
#pragma unroll
    for (int j = -2; j <= 2; ++j) {
        const std::int16_t* const row = in.map.row(at.y + j) + at.x;
        const std::uint32_t* const slopes = fitted.row(at.y + j) + at.x;
#pragma unroll
        for (int i = -2; i <= 2; ++i) {
            if (!step::is_dark(i, j)) continue;
            const int on = step::on_same_surface<int>(row[i], own);
            count -= on;
            sums += slopes[i] & static_cast<std::uint32_t>(on);
        }
    }
    const int sum_x = static_cast<int>(sums & 0xffffu) - count * step::kSteepest,
              sum_y = static_cast<int>(sums >> 16) - count * step::kSteepest;
    const bool first_round = in.voter_weights.origin != nullptr;
    const std::uint8_t weight = first_round ? in.voter_weights.at(at.x, at.y) : step::kMatchedWeight;
    write_record({own, step::mean_slope(sum_x, count), step::mean_slope(sum_y, count), weight,
                  in.colors.at(at.x, at.y), first_round ? blurred(in.colors, at.x, at.y) : 0},
                 &out.at(at.x, at.y));
}

}  // namespace

void find_slopes(cudaStream_t stream, const RecordInput& input, const FittedSlopes& fitted,
                 const RasterView<PixelRecord>& records) {
    const dim3 grid = pixel_grid(input.map.width, input.map.height);
    fit_slopes<<<grid, pixel_block(), 0, stream>>>(input.map, fitted);
    check_launch("fitting slopes");
    average_slopes<<<grid, pixel_block(), 0, stream>>>(input, reading(fitted), records);
    check_launch("averaging slopes");
}

}  // namespace hexrelief::cuda
