// Depth maps, as depth cameras, networks and renderers give them.
#pragma once

#include <cmath>
#include <limits>
#include <vector>

namespace hexrelief {

inline constexpr float kUnknownDepth = std::numeric_limits<float>::infinity();

// Row-major, top row first. Depths are along the optical axis unless said otherwise. Known depths are above
// 0; unknown ones are +infinity, never NaN.
struct DepthMap {
    int width = 0;
    int height = 0;
    std::vector<float> values = {};  // width * height; metres, or any unit if not metric
    bool metric = true;
    // The quantisation step of a map with integer samples: the difference of two adjacent sample values, as a
    // depth, or as 1 / depth if is_inverse. 0 = the samples are floats.
    double step = 0;
    bool is_inverse = false;  // the samples are 1 / depth, and so is the step

    static bool known(float depth) { return std::isfinite(depth); }
};

}  // namespace hexrelief
