#include "pipeline/stages/dequantize/dequantize.h"

#include "pipeline/base/thread_pool.h"
#include "pipeline/stages/dequantize/evidence.h"
#include "pipeline/stages/dequantize/pyramid.h"
#include "pipeline/stages/dequantize/relax.h"

namespace hexrelief::stages {
namespace {

// Largest difference of neighbours on one surface; the surface stage's own default.
constexpr float kJoined_px = 1.0001f;
// Share of half a quantum: whole pixels that are two apart must stay more than 1 px apart, a discontinuity.
constexpr double kFree = 0.97;
constexpr float kPullGrowth = 16;  // from one level to the next

}  // namespace

DisparityMap dequantize(const DisparityMap& map, double quantum_px, int threads,
                        const Smoothness& smoothness) {
    DisparityMap result = map;
    ThreadPool pool(threads);
    const auto half_px = static_cast<float>(0.5 * kFree * quantum_px);
    std::vector<PyramidLevel> pyramid = build_pyramid(map, half_px, kJoined_px, smoothness.levels, pool);
    std::vector<float> pulls = {smoothness.pull};
    while (pulls.size() < pyramid.size()) pulls.push_back(kPullGrowth * pulls.back());
    for (std::size_t level = pyramid.size(); level-- > 0;) {
        if (level + 1 < pyramid.size()) prolong(pyramid[level + 1], pyramid[level], half_px, pool);
        relax(pyramid[level], pulls[level], half_px, pool);
    }
    const PyramidLevel& fine = pyramid.front();
    for_rows(pool, map.height, [&](int y) {
        for (int x = 0; x < map.width; ++x)
            if (fine.flags[fine.at(x, y)] & kIsSmoothed) result.at(x, y) = fine.smooth[fine.at(x, y)];
    });
    return result;
}

}  // namespace hexrelief::stages
