// Colour differences between a left pixel and the right pixel at a disparity, on packed colours.
#pragma once

#include <cstdint>

#include "cuda/matching/common/device_raster.h"
#include "cuda/matching/common/pixels.cuh"
#include "pipeline/matching/refine/consistency_step.h"
#include "pipeline/matching/refine/match_color_step.h"

namespace hexrelief::cuda {

// Returns the sum over three channels. right: a row of the right picture, which repeats its edge.
HEXRELIEF_HD int match_difference(std::uint32_t left, const std::uint32_t* right, int width,
                                  const step::RightPosition& at) {
    const std::uint32_t here = right[clamped(at.column, width)], next = right[clamped(at.column + 1, width)];
    int sum = 0;
    for (int c = 0; c < step::kMatchChannels; ++c)
        sum += step::match_difference(channel_of(left, c), channel_of(here, c), channel_of(next, c),
                                      at.sixteenths);
    return sum;
}

// The difference between a pixel's colour and that of its match at a disparity.
struct PixelDifference {
    const std::uint32_t* right;  // row of the right picture
    step::RowSite site;
    std::uint32_t own;

    HEXRELIEF_HD int operator()(int disparity) const {
        return match_difference(own, right, site.width,
                                step::position_in_right(site.x, site.min_px, disparity));
    }
};

// Returns the sum over the 3x3 pixels around (x, y).
HEXRELIEF_HD int window_difference(const PackedColors& left, const PackedColors& right, int x, int y,
                                   const step::RightPosition& at) {
    int sum = 0;
    for (int j = -1; j <= 1; ++j)
        for (int i = -1; i <= 1; ++i) {
            const int row = clamped(y + j, left.height);
            sum += match_difference(left.at(clamped(x + i, left.width), row), right.row(row), right.width,
                                    {at.column + i, at.sixteenths});
        }
    return sum;
}

}  // namespace hexrelief::cuda
