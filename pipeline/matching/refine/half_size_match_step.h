// What the match of the pair at half size says of a pixel that was not matched at full size: noise and weak
// texture hide a surface at full size that four pixels' mean still shows.
#pragma once

#include <cstdint>

#include "mesher/common/host_device.h"
#include "pipeline/matching/common/bordered_raster.h"
#include "pipeline/matching/refine/consistency_step.h"

namespace hexrelief::step {

inline constexpr int kSameSurface = 24;  // 1/16 px

// half: trusted matches at half size, 1/16 px above half_min_px. right: trusted matches of the right view,
// row y, at full size. In 1/16 px above min_px; unknown where one of the 3x3 pixels at half size is, or where
// the right pixel that it leads to is outside or has a match on another surface.
HEXRELIEF_HD std::int16_t half_size_match(matching::DisparityView half, int half_min_px,
                                          const std::int16_t* right, int width, int min_px, int x, int y) {
    const std::int16_t* at = &half.at(x / 2, y / 2);
    for (int j = -1; j <= 1; ++j)
        for (int i = -1; i <= 1; ++i)
            if (at[j * half.stride + i] < 0) return matching::kUnknown16;
    const int disparity = 2 * *at + matching::kOnePixel * (2 * half_min_px - min_px);
    const int column = matching_column(x, min_px, disparity);
    if (disparity < 0 || column < 0 || column >= width) return matching::kUnknown16;
    const int difference = right[column] - disparity;
    const bool same = difference <= kSameSurface && difference >= -kSameSurface;
    return right[column] < 0 || same ? static_cast<std::int16_t>(disparity) : matching::kUnknown16;
}

}  // namespace hexrelief::step
