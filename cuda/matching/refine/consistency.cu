#include "cuda/matching/common/pixels.cuh"
#include "cuda/matching/refine/consistency.h"
#include "pipeline/matching/refine/consistency_step.h"
#include "pipeline/matching/refine/half_size_match_step.h"
#include "pipeline/matching/refine/median_step.h"

namespace hexrelief::cuda {
namespace {

__global__ void filter_median_kernel(DisparityView map, DisparityOut out) {
    const int2 at = pixel_of_thread();
    if (at.x < map.width && at.y < map.height)
        out.at(at.x, at.y) = step::median_around(&map.at(at.x, at.y), map.stride);
}

__global__ void check_left_kernel(DisparityView left, DisparityView right, ConsistencyConfig config,
                                  DisparityOut checked) {
    const int2 at = pixel_of_thread();
    if (at.x < left.width && at.y < left.height)
        checked.at(at.x, at.y) =
            step::checked_match(left.at(at.x, at.y), right.row(at.y), at.x, left.width, config);
}

__global__ void find_trusted_kernel(DisparityView checked, DisparityView right, int min_px, int limit,
                                    TrustedRasters out) {
    const int2 at = pixel_of_thread();
    if (at.x >= right.width || at.y >= right.height) return;
    const std::int16_t own = right.at(at.x, at.y);
    out.right.at(at.x, at.y) = step::agreed(
        own, checked.row(at.y), step::matching_left_column(at.x, min_px, own), right.width, limit);
    out.matched.at(at.x, at.y) = checked.at(at.x, at.y) != kUnknown16;
}

__global__ void add_half_size_kernel(DisparityView half, int half_min_px, DisparityView right, int min_px,
                                     DisparityOut checked) {
    const int2 at = pixel_of_thread();
    if (at.x >= checked.width || at.y >= checked.height || checked.at(at.x, at.y) >= 0) return;
    checked.at(at.x, at.y) =
        step::half_size_match(half, half_min_px, right.row(at.y), checked.width, min_px, at.x, at.y);
}

__global__ void find_nearest_seen(DisparityView trusted, RasterView<std::int32_t> out) {
    const int2 at = pixel_of_thread();
    if (at.x < trusted.width && at.y < trusted.height)
        out.at(at.x, at.y) = step::nearest_seen(&trusted.at(at.x, at.y));
}

}  // namespace

void filter_median(cudaStream_t stream, const DisparityView& map, const DisparityOut& out) {
    filter_median_kernel<<<pixel_grid(map.width, map.height), pixel_block(), 0, stream>>>(map, out);
    check_launch("the median filter");
}

void check_left(cudaStream_t stream, const DisparityView& left, const DisparityView& right,
                const ConsistencyConfig& config, const DisparityOut& checked) {
    check_left_kernel<<<pixel_grid(left.width, left.height), pixel_block(), 0, stream>>>(left, right, config,
                                                                                         checked);
    check_launch("comparing the views");
}

void find_trusted(cudaStream_t stream, const DisparityView& checked, const DisparityView& right,
                  const ConsistencyConfig& config, const TrustedRasters& out) {
    const dim3 grid = pixel_grid(right.width, right.height);
    const int limit = config.left_right_limit >= 0 ? config.left_right_limit : kOnePixel;
    find_trusted_kernel<<<grid, pixel_block(), 0, stream>>>(checked, right, config.min_px, limit, out);
    check_launch("comparing the views");
    find_nearest_seen<<<grid, pixel_block(), 0, stream>>>(reading(out.right), out.nearest_seen);
    check_launch("finding what the right camera sees");
}

void add_half_size_matches(cudaStream_t stream, const DisparityView& half, int half_min_px,
                           const DisparityView& right, int min_px, const DisparityOut& checked) {
    add_half_size_kernel<<<pixel_grid(checked.width, checked.height), pixel_block(), 0, stream>>>(
        half, half_min_px, right, min_px, checked);
    check_launch("adding matches at half size");
}

}  // namespace hexrelief::cuda
