// Takes a pixel's match from the pair at half size if it was not matched at full size: noise and weak texture
// hide surfaces at full size that the mean of four pixels still shows.
#pragma once

#include <cstdint>

#include "pipeline/base/host_device.h"
#include "pipeline/matching/common/bordered_raster.h"
#include "pipeline/matching/refine/consistency_step.h"

namespace hexrelief::step {

inline constexpr int kSameSurface = 24;  // 1/16 px: matches that differ by more are on different surfaces

// Returns the half-size match of a pixel, in 1/16 px above min_px; kUnknown16 if one of the 3x3 pixels at
// half size is unknown, if the match is outside of the right picture, or if the right pixel has a match on
// another surface. half: trusted matches at half size, in 1/16 px above half_min_px. right: trusted matches
// of the right view's row y, at full size.
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
