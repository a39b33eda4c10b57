// Which neighbouring pixels lie on one surface: the disparity map without specks, with its depth jumps.
#pragma once

#include <cstdint>
#include <vector>

#include "mesher/sheet_config.h"
#include "mesher/steps/rim.h"
#include "pipeline/data/disparity_map.h"

namespace hexrelief {

struct PixelSurfaces {
    int width = 0;
    int height = 0;
    float jump_px = 0;
    std::vector<float> disparity;     // px, 0 = no foreground; a speck has its nearest neighbour's
    std::vector<std::uint8_t> flags;  // step::kJumpRight ...

    step::PixelView view() const { return {width, height, disparity.data(), flags.data()}; }
};

// Regions of fewer than `least_px` pixels between jumps are specks, of the foreground as well as holes in it:
// they get the disparity of the region around them and do not count in fits.
PixelSurfaces find_surfaces(const DisparityMap& map, float background_px, int least_px,
                            const SheetConfig& config);

}  // namespace hexrelief
