#include "pipeline/dequantize/dequantize.h"

#include "mesher/common/thread_pool.h"
#include "pipeline/dequantize/pyramid.h"
#include "pipeline/dequantize/relax.h"

namespace hexrelief::dequantize {
namespace {

// Largest difference of neighbours on one surface; the surface stage's own default.
constexpr float kJoined_px = 1.0001f;
// Share of half a quantum: whole pixels that are two apart must stay more than 1 px apart, a discontinuity.
constexpr double kFree = 0.97;
constexpr int kLevels = 5;
// Weight of the given disparities against the bending of waves of one pixel. A wave twice as long bends 16
// times less. Waves longer than some 30 px follow the given disparities.
constexpr float kPull = 0.002f, kPullGrowth = 16;

}  // namespace

DisparityMap dequantize(const DisparityMap& map, double quantum_px, int threads) {
    DisparityMap result = map;
    ThreadPool pool(threads);
    const auto half_px = static_cast<float>(0.5 * kFree * quantum_px);
    std::vector<PyramidLevel> pyramid = build_pyramid(map, half_px, kJoined_px, kLevels, pool);
    float pulls[kLevels] = {kPull};
    for (int level = 1; level < kLevels; ++level) pulls[level] = kPullGrowth * pulls[level - 1];
    for (std::size_t level = pyramid.size(); level-- > 0;) {
        if (level + 1 < pyramid.size()) prolong(pyramid[level + 1], pyramid[level], half_px, pool);
        relax(pyramid[level], pulls[level], half_px, pool);
    }
    const PyramidLevel& fine = pyramid.front();
    for (int y = 0; y < map.height; ++y)
        for (int x = 0; x < map.width; ++x)
            if (fine.flags[fine.at(x, y)] & kIsSmoothed) result.at(x, y) = fine.smooth[fine.at(x, y)];
    return result;
}

}  // namespace hexrelief::dequantize
