// Makes up textured pairs with known disparities, occlusions and untextured parts.
#pragma once

#include <cstdint>

#include "pipeline/data/disparity_map.h"

namespace hexrelief::testing_cuda {

struct PairSpec {
    int width = 0, height = 0;
    int left_channels = 3, right_channels = 3;
    int nearest_px = 0, farthest_px = 0;  // of the disparities, which may be negative
    std::uint32_t seed = 1;
};

// Returns an inclined plane with boxes in front of it at other disparities, some in one colour; noise of 2
// % in both pictures.
StereoPair made_up_pair(const PairSpec& spec);

}  // namespace hexrelief::testing_cuda
