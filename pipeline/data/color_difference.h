// How far two pixels' colours are apart.
#pragma once

#include <cstddef>
#include <cstdlib>

#include "pipeline/data/image.h"

namespace hexrelief {

// Returns the sum of the channels' differences of two pixels, given by their places in rows: 0 to 255 each.
inline int color_difference(const Image& image, std::size_t pixel, std::size_t other) {
    const auto channels = static_cast<std::size_t>(image.channels);
    int sum = 0;
    for (std::size_t c = 0; c < channels; ++c)
        sum += std::abs(image.pixels[pixel * channels + c] - image.pixels[other * channels + c]);
    return sum;
}

}  // namespace hexrelief
