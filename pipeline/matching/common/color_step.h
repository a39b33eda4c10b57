// Colours of pixels: luminance, and the distance between two colours; and the geometry of a picture at half
// its size.
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

// Returns the number of columns, or rows, at half size; if the count is odd, the last one covers only one.
HEXRELIEF_HD int half_size(int count) {
    return (count + 1) / 2;
}

// Returns the first of the two columns, or rows, at full size that column, or row, i at half size covers.
HEXRELIEF_HD int first_covered(int i) {
    return 2 * i;
}
// Returns the second of them; at the edge it equals the first.
HEXRELIEF_HD int second_covered(int i, int count) {
    return 2 * i + 1 < count ? 2 * i + 1 : count - 1;
}

HEXRELIEF_HD std::uint8_t rounded_mean(int a, int b, int c, int d) {
    return static_cast<std::uint8_t>((a + b + c + d + 2) >> 2);
}

}  // namespace hexrelief::step
