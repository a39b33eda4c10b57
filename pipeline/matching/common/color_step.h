// Colours of pixels: luminance, and the distance between two colours.
#pragma once

#include <cstdint>

#include "pipeline/base/host_device.h"

namespace hexrelief::step {

// Returns the luminance by ITU-R BT.601's weights of red, green and blue, in 1/2^15.
HEXRELIEF_HD std::uint8_t luminance(int red, int green, int blue) {
    return static_cast<std::uint8_t>((9798 * red + 19235 * green + 3735 * blue + (1 << 14)) >> 15);
}

HEXRELIEF_HD std::uint8_t distance(std::uint8_t a, std::uint8_t b) {
    return static_cast<std::uint8_t>((a > b ? a : b) - (a > b ? b : a));
}

// Returns the mean of nine channel values, given their sum.
HEXRELIEF_HD std::uint8_t rounded_ninth(std::uint16_t sum) {
    return static_cast<std::uint8_t>((sum + 4) / 9);
}

}  // namespace hexrelief::step
