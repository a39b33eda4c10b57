// Parts of images.
#pragma once

#include "pipeline/data/image.h"

namespace hexrelief {

struct PixelRect {
    int x = 0, y = 0, width = 0, height = 0;
};

// Returns a copy of the part `rect`, with its alpha if the image has any. The part must lie inside the image.
inline Image cropped(const Image& image, const PixelRect& rect) {
    Image part{rect.width, rect.height, image.channels, {}};
    part.pixels.reserve(static_cast<std::size_t>(rect.width) * rect.height * image.channels);
    for (int row = rect.y; row < rect.y + rect.height; ++row) {
        part.pixels.insert(part.pixels.end(), image.at(rect.x, row), image.at(rect.x + rect.width, row));
        if (image.alpha.empty()) continue;
        const auto from = image.alpha.begin() + static_cast<std::ptrdiff_t>(row) * image.width + rect.x;
        part.alpha.insert(part.alpha.end(), from, from + rect.width);
    }
    return part;
}

}  // namespace hexrelief
