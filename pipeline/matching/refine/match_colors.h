// Differences of colours between left pixels and the right pixels that they match.
#pragma once

#include "pipeline/matching/common/color_planes.h"
#include "pipeline/matching/refine/match_color_step.h"

namespace hexrelief::matching {

// Returns the sum over three channels; for grey, three times the one. (x, y) and the column may
// lie in the border.
inline int match_difference(const ColorView& left, const ColorView& right, int x, int y,
                            const step::RightPosition& at) {
    int sum = 0;
    for (int c = 0; c < left.channels; ++c) {
        const std::uint8_t* in_right = right.planes[c].row(y) + at.column;
        sum += step::match_difference(left.planes[c].at(x, y), in_right[0], in_right[1], at.sixteenths);
    }
    return sum * (step::kMatchChannels / left.channels);
}

// Returns the sum over 3x3 pixels around (x, y), which may lie in the border, except on its outermost pixels.
inline int window_difference(const ColorView& left, const ColorView& right, int x, int y,
                             const step::RightPosition& at) {
    int sum = 0;
    for (int j = -1; j <= 1; ++j)
        for (int i = -1; i <= 1; ++i)
            sum += match_difference(left, right, x + i, y + j, {at.column + i, at.sixteenths});
    return sum;
}

}  // namespace hexrelief::matching
