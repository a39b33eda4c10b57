#include "pipeline/stages/densify/densify.h"

#include <algorithm>

#include "pipeline/base/thread_pool.h"
#include "pipeline/data/start_work.h"
#include "pipeline/stages/densify/plane_votes.h"
#include "pipeline/stages/densify/planes.h"
#include "pipeline/stages/densify/reach.h"

namespace hexrelief::stages {
namespace {

constexpr int kHoleStride_px = 4;  // slopes are taken from up to three of these around a pixel
constexpr int kRim_px = 4 * kHoleStride_px;

// Returns the map's pixels that are near unknown ones; all others are unknown as well.
DisparityMap rims_of_holes(const DisparityMap& map) {
    std::vector<std::uint8_t> near(map.values.size());
    for (std::size_t i = 0; i < near.size(); ++i) near[i] = !DisparityMap::known(map.values[i]);
    spread_square(near, map.width, map.height, kRim_px, 1);
    DisparityMap rims = map;
    for (std::size_t i = 0; i < near.size(); ++i)
        if (!near[i]) rims.values[i] = kUnknownDisparity;
    return rims;
}

}  // namespace

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

DisparityMap fill_holes(const DisparityMap& map, const Image& left, int threads) {
    ThreadPool pool(threads);
    std::vector<PlaneAt> planes = measurements_of(rims_of_holes(map));
    auto by_colours = start_work(left.empty() ? 1 : threads,
                                 [&] { return find_nearest(planes, map.width, map.height, left); });
    const NearestMeasurements around = find_nearest(planes, map.width, map.height, {});
    const NearestMeasurements nearest = left.empty() ? around : by_colours.get();
    fit_planes(planes, around, kHoleStride_px, pool);
    const std::vector<std::uint8_t> all(map.values.size(), 1);
    const SideInput sides{planes, around, smoothed(left, pool), kHoleStride_px};
    return take_votes({map, planes, nearest, all, left, sides}, kHoleStride_px, pool);
}

}  // namespace hexrelief::stages
