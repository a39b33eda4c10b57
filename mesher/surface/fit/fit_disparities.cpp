#include "mesher/surface/fit/fit_disparities.h"

#include <algorithm>
#include <bit>
#include <cstdint>
#include <limits>

#include "mesher/surface/fit/disparity_fitter_step.h"
#include "pipeline/base/simd.h"
#include "pipeline/base/thread_team.h"

namespace hexrelief::surface {
namespace {

// Returns the smallest disparity above 0; the largest float if there is none. Non-negative floats have the
// order of their bits, whose minimum vectorises; subtracting 1 makes a 0 wrap around to the largest number.
HEXRELIEF_VECTORS float smallest_disparity(const float* disparity, std::size_t count) {
    std::uint32_t least = std::bit_cast<std::uint32_t>(std::numeric_limits<float>::max()) - 1;
    for (std::size_t i = 0; i < count; ++i)
        least = std::min(least, std::bit_cast<std::uint32_t>(disparity[i]) - 1);
    return std::bit_cast<float>(least + 1);
}

float smallest_disparity(const step::PixelView& view, ThreadPool& pool) {
    std::vector<float> smallest(static_cast<std::size_t>(pool.size()));
    const std::size_t pixels = static_cast<std::size_t>(view.width) * view.height;
    pool.run([&](int thread) {
        const std::size_t first = pool.share(pixels, thread), end = pool.share(pixels, thread + 1);
        smallest[static_cast<std::size_t>(thread)] = smallest_disparity(view.disparity + first, end - first);
    });
    return *std::min_element(smallest.begin(), smallest.end());
}

}  // namespace

std::vector<float> fit_disparities(const PixelSurfaces& surfaces, const TriangleLabels& labels,
                                   const CutTriangles& cut, float farthest_px, ThreadPool& pool) {
    const std::size_t points = cut.points.size(), triangles = cut.triangles.size();
    const float smallest = smallest_disparity(surfaces.view(), pool);
    const double least = step::lowest_disparity(farthest_px > 0 ? std::min(farthest_px, smallest) : smallest);
    RawVector<unsigned> starts(points), ends(points);
    RawVector<std::uint32_t> corners(3 * triangles);
    RawVector<step::FitTriangle> sums(triangles);
    RawVector<step::FitTerm> terms(3 * triangles);
    RawVector<step::FitEquation> equations(points);
    RawVector<double> values(points), next(points);
    const step::FitArrays arrays{{starts.data(), ends.data(), corners.data()},
                                 sums.data(),
                                 terms.data(),
                                 equations.data(),
                                 {values.data(), next.data()}};
    const auto runs = [&](std::uint32_t t) {
        return step::PixelRuns{labels.fitted[t].data(), labels.fitted[t].size()};
    };
    std::vector<float> disparities(points);
    ThreadTeam::run(pool, [&](ThreadTeam& team) {
        step::DisparityFitter(team, surfaces.view(), surfaces.tiles(), cut.view(), cut.points.data(),
                              labels.anchors.data(), runs, arrays)
            .fit(least, disparities.data());
    });
    return disparities;
}

}  // namespace hexrelief::surface
