#include "pipeline/densify/densify.h"

#include <algorithm>

#include "mesher/common/thread_pool.h"
#include "pipeline/densify/plane_votes.h"
#include "pipeline/densify/planes.h"
#include "pipeline/densify/reach.h"

namespace hexrelief::densify {

DisparityMap densify(const DisparityMap& sparse, const Image& left, int threads) {
    ThreadPool pool(threads);
    std::vector<PlaneAt> planes = measurements_of(sparse);
    const NearestMeasurements around = find_nearest(planes, sparse.width, sparse.height, {});
    const int typical_px = typical_distance_px(sparse, around);
    const std::vector<std::uint8_t> filled = pixels_to_fill(sparse, around, typical_px);
    const NearestMeasurements nearest =
        left.empty() ? around : find_nearest(planes, sparse.width, sparse.height, left);
    const int stride_px = std::max(1, (4 * typical_px + 2) / 5);
    fit_planes(planes, nearest, stride_px, pool);
    const SideInput sides{planes, around, smoothed(left, pool), stride_px};
    return take_votes({sparse, planes, nearest, filled, left, sides}, stride_px, pool);
}

}  // namespace hexrelief::densify
