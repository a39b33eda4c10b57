// Colour steps between a run of pixels and the pixels at an offset, for loops that the compiler vectorises.
#pragma once

#include <cstddef>
#include <cstdint>

#include "pipeline/base/simd.h"
#include "pipeline/matching/common/color_planes.h"
#include "pipeline/matching/common/color_step.h"

namespace hexrelief::matching {

// Sets out[x] to the largest difference of a channel between pixel (x0 + x, y) and the pixel
// (dx, dy) px away.
HEXRELIEF_INLINED void color_steps(const ColorView& colors, int x0, int y, int dx, int dy, int count,
                                   std::uint8_t* __restrict out) {
    for (int c = 0; c < colors.channels; ++c) {
        const std::uint8_t* own = colors.planes[c].row(y) + x0;
        const std::uint8_t* other = colors.planes[c].row(y + dy) + x0 + dx;
        if (c == 0) {
            for (int x = 0; x < count; ++x) out[x] = step::distance(own[x], other[x]);
            continue;
        }
        for (int x = 0; x < count; ++x) {
            const std::uint8_t difference = step::distance(own[x], other[x]);
            out[x] = difference > out[x] ? difference : out[x];
        }
    }
}

}  // namespace hexrelief::matching
