// The pixels beside, above and below a pixel.
#pragma once

#include <cstddef>

namespace hexrelief {

// Calls take(i) for each of them in a picture of width x height pixels, which are numbered row by row.
template <typename Take>
void for_four_neighbours(std::size_t pixel, int width, int height, const Take& take) {
    const auto across = static_cast<std::size_t>(width);
    if (pixel % across > 0) take(pixel - 1);
    if (pixel % across + 1 < across) take(pixel + 1);
    if (pixel >= across) take(pixel - across);
    if (pixel + across < across * static_cast<std::size_t>(height)) take(pixel + across);
}

}  // namespace hexrelief
