#include "cuda/matching/common/pixels.cuh"
#include "cuda/matching/refine/slopes.h"
#include "pipeline/matching/refine/slope_step.h"

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

__global__ void average_slopes(DisparityView map, DisparityView fitted_x, DisparityView fitted_y,
                               SlopeRasters out) {
    const int2 at = pixel_of_thread();
    if (at.x >= map.width || at.y >= map.height) return;
    const std::int16_t own = map.at(at.x, at.y);
    std::int16_t count = 0, sum_x = 0, sum_y = 0;
#pragma unroll
    for (int j = -2; j <= 2; ++j)
#pragma unroll
        for (int i = -2; i <= 2; ++i) {
            const int x = at.x + i, y = at.y + j;
            const std::int16_t on = step::on_same_surface(map.at(x, y), own);
            count = static_cast<std::int16_t>(count - on);
            sum_x = static_cast<std::int16_t>(sum_x + (fitted_x.at(x, y) & on));
            sum_y = static_cast<std::int16_t>(sum_y + (fitted_y.at(x, y) & on));
        }
    out.x.at(at.x, at.y) = step::mean_slope(sum_x, count);
    out.y.at(at.x, at.y) = step::mean_slope(sum_y, count);
}

}  // namespace

void find_slopes(cudaStream_t stream, const DisparityView& map, const SlopeReach& reach,
                 const SlopeRasters& fitted, const SlopeRasters& means) {
    const dim3 grid = pixel_grid(map.width, map.height);
    const auto fit = reach.samples == 4 ? fit_slopes<4> : fit_slopes<5>;
    fit<<<grid, pixel_block(), 0, stream>>>(map, reach.largest_step, fitted);
    check_launch("fitting slopes");
    average_slopes<<<grid, pixel_block(), 0, stream>>>(map, reading(fitted.x), reading(fitted.y), means);
    check_launch("averaging slopes");
}

}  // namespace hexrelief::cuda
