// The geometry of a picture at half its size.
#pragma once

#include <cstdint>

#include "pipeline/base/host_device.h"

namespace hexrelief::step {

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
