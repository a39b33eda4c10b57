// Distances as depth cameras, networks and renderers give them.
#pragma once

#include <cmath>
#include <limits>
#include <vector>

namespace hexrelief {

inline constexpr float kUnknownDepth = std::numeric_limits<float>::infinity();

// Row-major, top row first; along the optical axis unless said otherwise. Known depths are above 0; unknown
// is +infinity, never NaN.
struct DepthMap {
    int width = 0;
    int height = 0;
    std::vector<float> values;  // width * height; metres, or any unit where not metric
    bool metric = true;
    // Of integer samples: the distance of two neighbouring ones, in units of depth, or of 1 / depth where the
    // samples are inverse depths. 0 = the samples are floats.
    double step = 0;
    bool is_inverse = false;  // the step is one of 1 / depth

    static bool known(float depth) { return std::isfinite(depth); }
};

}  // namespace hexrelief
