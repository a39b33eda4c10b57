// The median of nine numbers, without branches.
#pragma once

#include <cstdint>

#include "pipeline/base/host_device.h"

namespace hexrelief::step {

HEXRELIEF_HD void sort_two(std::int16_t& a, std::int16_t& b) {
    const std::int16_t less = a < b ? a : b, more = a < b ? b : a;
    a = less;
    b = more;
}

// Returns the median, by Paeth's network of 19 exchanges (Graphics Gems, 1990).
HEXRELIEF_HD std::int16_t median_of_nine(std::int16_t v[9]) {
    sort_two(v[1], v[2]);
    sort_two(v[4], v[5]);
    sort_two(v[7], v[8]);
    sort_two(v[0], v[1]);
    sort_two(v[3], v[4]);
    sort_two(v[6], v[7]);
    sort_two(v[1], v[2]);
    sort_two(v[4], v[5]);
    sort_two(v[7], v[8]);
    sort_two(v[0], v[3]);
    sort_two(v[5], v[8]);
    sort_two(v[4], v[7]);
    sort_two(v[3], v[6]);
    sort_two(v[1], v[4]);
    sort_two(v[2], v[5]);
    sort_two(v[4], v[7]);
    sort_two(v[4], v[2]);
    sort_two(v[6], v[4]);
    sort_two(v[4], v[2]);
    return v[4];
}

// Returns the median of a pixel and its eight neighbours. Unknown neighbours count as the pixel itself. An
// unknown pixel counts as less than any disparity, so it becomes known if five or more neighbours are known.
HEXRELIEF_HD std::int16_t median_around(const std::int16_t* at, std::ptrdiff_t stride) {
    const std::int16_t own = *at;
    std::int16_t v[9] = {at[-stride - 1], at[-stride],    at[-stride + 1], at[-1],        own,
                         at[1],           at[stride - 1], at[stride],      at[stride + 1]};
    for (std::int16_t& value : v) value = value < 0 ? own : value;
    return median_of_nine(v);
}

}  // namespace hexrelief::step
