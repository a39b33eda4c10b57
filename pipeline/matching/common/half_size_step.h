// A picture at half its size.
#pragma once

#include <cstdint>

#include "mesher/common/host_device.h"

namespace hexrelief::step {

// Columns, or rows, of half the size; the last one of an odd count is a half wide.
HEXRELIEF_HD int half_size(int count) {
    return (count + 1) / 2;
}

// The first of the two columns, or rows, at full size that number i covers, and the second, which repeats the
// edge.
HEXRELIEF_HD int first_covered(int i) {
    return 2 * i;
}
HEXRELIEF_HD int second_covered(int i, int count) {
    return 2 * i + 1 < count ? 2 * i + 1 : count - 1;
}

HEXRELIEF_HD std::uint8_t rounded_mean(int a, int b, int c, int d) {
    return static_cast<std::uint8_t>((a + b + c + d + 2) >> 2);
}

}  // namespace hexrelief::step
