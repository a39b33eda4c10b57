// The difference between a left pixel's colour and the colour of its match in the right picture.
#pragma once

#include <cstdint>

#include "pipeline/base/host_device.h"
#include "pipeline/matching/common/bordered_raster.h"
#include "pipeline/matching/common/color_step.h"

namespace hexrelief::step {

// Differences are sums over three channels; for grey, three times the one.
inline constexpr int kMatchChannels = 3;
inline constexpr int kMatchColorCut = 40;  // a channel's difference counts up to this

// The position in the right picture of a left pixel's match.
struct RightPosition {
    int column, sixteenths;  // between this column and the next one
};

// True if the right picture contains the match of the left pixel in column x.
HEXRELIEF_HD bool is_in_right(int x, int width, int min_px, int disparity) {
    const int position = matching::kOnePixel * (x - min_px) - disparity;
    return position >= 0 && position <= matching::kOnePixel * (width - 1);
}
// Returns the position of the match; only if is_in_right().
HEXRELIEF_HD RightPosition position_in_right(int x, int min_px, int disparity) {
    const int position = matching::kOnePixel * (x - min_px) - disparity;
    return {position / matching::kOnePixel, position % matching::kOnePixel};
}

// Returns a channel's difference between the left pixel and the interpolated value of two columns
// of the right picture.
HEXRELIEF_HD int match_difference(std::uint8_t left, std::uint8_t right, std::uint8_t next, int sixteenths) {
    const int between =
        (right * (matching::kOnePixel - sixteenths) + next * sixteenths + matching::kOnePixel / 2) >> 4;
    const int difference = distance(left, static_cast<std::uint8_t>(between));
    return difference < kMatchColorCut ? difference : kMatchColorCut;
}

}  // namespace hexrelief::step
