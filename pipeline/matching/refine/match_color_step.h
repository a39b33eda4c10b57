// How far the colour of a left pixel is from the one that the right picture has for a disparity.
#pragma once

#include <cstdint>

#include "mesher/common/host_device.h"
#include "pipeline/matching/common/bordered_raster.h"
#include "pipeline/matching/common/color_step.h"

namespace hexrelief::step {

inline constexpr int kMatchChannels = 3;   // differences are sums over three channels, of grey thrice the one
inline constexpr int kMatchColorCut = 40;  // a channel's difference counts up to this

// Where the right picture shows a disparity of a left pixel.
struct RightPosition {
    int column, sixteenths;  // between this column and the next
};

// Whether the right picture shows a disparity of the left pixel in column x.
HEXRELIEF_HD bool is_in_right(int x, int width, int min_px, int disparity) {
    const int position = matching::kOnePixel * (x - min_px) - disparity;
    return position >= 0 && position <= matching::kOnePixel * (width - 1);
}
// Only where it does.
HEXRELIEF_HD RightPosition position_in_right(int x, int min_px, int disparity) {
    const int position = matching::kOnePixel * (x - min_px) - disparity;
    return {position / matching::kOnePixel, position % matching::kOnePixel};
}

// Of a channel: the left pixel's, and those of the two columns of the right picture.
HEXRELIEF_HD int match_difference(std::uint8_t left, std::uint8_t right, std::uint8_t next, int sixteenths) {
    const int between =
        (right * (matching::kOnePixel - sixteenths) + next * sixteenths + matching::kOnePixel / 2) >> 4;
    const int difference = distance(left, static_cast<std::uint8_t>(between));
    return difference < kMatchColorCut ? difference : kMatchColorCut;
}

}  // namespace hexrelief::step
