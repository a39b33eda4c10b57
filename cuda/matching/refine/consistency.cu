#include "cuda/matching/common/pixel_list.cuh"
#include "cuda/matching/refine/consistency.h"
#include "pipeline/matching/refine/consistency_step.h"
#include "pipeline/matching/refine/half_size_match_step.h"
#include "pipeline/matching/refine/median_step.h"

namespace hexrelief::cuda {
namespace {

// blockIdx.z: index in `medians`.
struct Medians {
    Median medians[2];
};
__global__ void filter_medians_kernel(const __grid_constant__ Medians both) {
    begin_kernel();
    const auto& [map, out] = both.medians[blockIdx.z];
    const int2 at = pixel_of_thread();
    if (at.x < map.width && at.y < map.height)
        out.at(at.x, at.y) = step::median_around(&map.at(at.x, at.y), map.stride);
}

__global__ void check_left_kernel(matching::DisparityView left, matching::DisparityView right,
                                  matching::ConsistencyConfig config, matching::DisparityOut checked) {
    begin_kernel();
    const int2 at = pixel_of_thread();
    if (at.x < left.width && at.y < left.height)
        checked.at(at.x, at.y) =
            step::checked_match(left.at(at.x, at.y), right.row(at.y), at.x, left.width, config);
}

__global__ void find_trusted_kernel(matching::DisparityView checked, matching::DisparityView right,
                                    int min_px, int limit, TrustedRasters out) {
    begin_kernel();
    const int2 at = pixel_of_thread();
    const bool inside = at.x < right.width && at.y < right.height;
    bool matched = false;
    if (inside) {
        const std::int16_t own = right.at(at.x, at.y);
        out.right.at(at.x, at.y) = step::agreed(
            own, checked.row(at.y), step::matching_left_column(at.x, min_px, own), right.width, limit);
        out.matched.at(at.x, at.y) = matched = checked.at(at.x, at.y) != matching::kUnknown16;
    }
    add_to_list(out.holes, inside && !matched, at);
}

__global__ void add_half_size_kernel(matching::DisparityView half, int half_min_px,
                                     matching::DisparityView right, int min_px,
                                     matching::DisparityOut checked) {
    begin_kernel();
    const int2 at = pixel_of_thread();
    if (at.x >= checked.width || at.y >= checked.height || checked.at(at.x, at.y) >= 0) return;
    checked.at(at.x, at.y) =
        step::half_size_match(half, half_min_px, right.row(at.y), checked.width, min_px, at.x, at.y);
}

__global__ void find_nearest_seen(matching::DisparityView trusted, matching::RasterView<std::int32_t> out) {
    begin_kernel();
    const int2 at = pixel_of_thread();
    if (at.x < trusted.width && at.y < trusted.height)
        out.at(at.x, at.y) = step::nearest_seen(&trusted.at(at.x, at.y));
}

}  // namespace

void filter_median(cudaStream_t stream, const Median& median) {
    launch("the median filter", stream, pixel_blocks(median.map.width, median.map.height),
           filter_medians_kernel, Medians{{median, {}}});
}
void filter_medians(cudaStream_t stream, const Median& first, const Median& second) {
    launch("the median filter", stream, pixel_blocks(first.map.width, first.map.height, 2),
           filter_medians_kernel, Medians{{first, second}});
}

void check_left(cudaStream_t stream, const matching::DisparityView& left,
                const matching::DisparityView& right, const matching::ConsistencyConfig& config,
                const matching::DisparityOut& checked) {
    launch("comparing the views", stream, pixel_blocks(left.width, left.height), check_left_kernel, left,
           right, config, checked);
}

void find_trusted(cudaStream_t stream, const matching::DisparityView& checked,
                  const matching::DisparityView& right, const matching::ConsistencyConfig& config,
                  const TrustedRasters& out) {
    const Blocks blocks = pixel_blocks(right.width, right.height);
    const int limit = config.left_right_limit >= 0 ? config.left_right_limit : matching::kOnePixel;
    launch("comparing the views", stream, blocks, find_trusted_kernel, checked, right, config.min_px, limit,
           out);
    launch("finding what the right camera sees", stream, blocks, find_nearest_seen, reading(out.right),
           out.nearest_seen);
}

void add_half_size_matches(cudaStream_t stream, const matching::DisparityView& half, int half_min_px,
                           const matching::DisparityView& right, int min_px,
                           const matching::DisparityOut& checked) {
    launch("adding matches at half size", stream, pixel_blocks(checked.width, checked.height),
           add_half_size_kernel, half, half_min_px, right, min_px, checked);
}

}  // namespace hexrelief::cuda
