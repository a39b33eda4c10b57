#include "cuda/matching/common/pixels.cuh"
#include "cuda/matching/refine/record_access.cuh"
#include "cuda/matching/refine/slopes.h"
#include "pipeline/matching/refine/slope_step.h"
#include "pipeline/matching/refine/vote_step.h"

namespace hexrelief::cuda {
namespace {

// Of the pixels `along` entries apart.
template <int kSamples>
__device__ std::int16_t fitted_slope(const std::int16_t* pixel, std::ptrdiff_t along,
                                     std::int16_t largest_step) {
    step::LineSums sums;
    const std::int16_t own = *pixel;
#pragma unroll
    for (int side = -1; side <= 1; side += 2) {
        std::int16_t on = step::mask_of(own >= 0), before = own;
#pragma unroll
        for (int k = 1; k <= kSamples; ++k) {
            const auto t = static_cast<std::int16_t>(side * k);
            const std::int16_t here = pixel[t * along];
            on = step::run_reaches(on, here, before, largest_step);
            step::add_sample(sums, t, static_cast<std::int16_t>(here - own), on);
            before = here;
        }
    }
    return step::slope_of(sums);
}

template <int kSamples>
__global__ void fit_slopes(DisparityView map, int largest_step, SlopeRasters out) {
    const int2 at = pixel_of_thread();
    if (at.x >= map.width || at.y >= map.height) return;
    const std::int16_t* const pixel = &map.at(at.x, at.y);
    const auto largest = static_cast<std::int16_t>(largest_step);
    out.x.at(at.x, at.y) = fitted_slope<kSamples>(pixel, 1, largest);
    out.y.at(at.x, at.y) = fitted_slope<kSamples>(pixel, map.stride, largest);
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

__global__ void average_slopes(RecordInput in, DisparityView fitted_x, DisparityView fitted_y,
                               RasterView<PixelRecord> out) {
    const int2 at = pixel_of_thread();
    if (at.x >= in.map.width || at.y >= in.map.height) return;
    const std::int16_t own = in.map.at(at.x, at.y);
    std::int16_t count = 0, sum_x = 0, sum_y = 0;
#pragma unroll
    for (int j = -2; j <= 2; ++j) {
        const std::int16_t* const row = in.map.row(at.y + j) + at.x;
        const std::int16_t *const row_x = fitted_x.row(at.y + j) + at.x, *const row_y =
                                                                             fitted_y.row(at.y + j) + at.x;
#pragma unroll
        for (int i = -2; i <= 2; ++i) {
            const std::int16_t on = step::on_same_surface(row[i], own);
            count = static_cast<std::int16_t>(count - on);
            sum_x = static_cast<std::int16_t>(sum_x + (row_x[i] & on));
            sum_y = static_cast<std::int16_t>(sum_y + (row_y[i] & on));
        }
    }
    const bool first_round = in.voter_weights.origin != nullptr;
    const std::uint8_t weight = first_round ? in.voter_weights.at(at.x, at.y) : step::kMatchedWeight;
    write_record({own, step::mean_slope(sum_x, count), step::mean_slope(sum_y, count), weight,
                  in.colors.at(at.x, at.y), first_round ? blurred(in.colors, at.x, at.y) : 0},
                 &out.at(at.x, at.y));
}

}  // namespace

void find_slopes(cudaStream_t stream, const RecordInput& input, const SlopeReach& reach,
                 const SlopeRasters& fitted, const RasterView<PixelRecord>& records) {
    const dim3 grid = pixel_grid(input.map.width, input.map.height);
    const auto fit = reach.samples == 4 ? fit_slopes<4> : fit_slopes<5>;
    fit<<<grid, pixel_block(), 0, stream>>>(input.map, reach.largest_step, fitted);
    check_launch("fitting slopes");
    average_slopes<<<grid, pixel_block(), 0, stream>>>(input, reading(fitted.x), reading(fitted.y), records);
    check_launch("averaging slopes");
}

}  // namespace hexrelief::cuda
