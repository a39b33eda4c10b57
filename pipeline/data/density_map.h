// The density map: the unnormalised probability density that the mesh adapts to.
#pragma once

#include <cstddef>
#include <vector>

namespace hexrelief {

// Row-major, top row first; one finite weight >= 0 per pixel; 0 = background or unknown (paper, section 3).
struct DensityMap {
    int width = 0;
    int height = 0;
    std::vector<float> values;  // width * height
    float background_px = 0;    // smaller disparities were removed as background

    float at(int x, int y) const { return values[static_cast<std::size_t>(y) * width + x]; }
};

}  // namespace hexrelief
