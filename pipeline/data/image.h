// 8-bit images, the form in which all stages see pictures.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace hexrelief {

// Row-major, top row first, channels interleaved (1 = grey, 3 = sRGB red green blue).
// Pixel (x, y) covers the unit square [x, x+1) x [y, y+1); its centre is at +0.5.
struct Image {
    int width = 0;
    int height = 0;
    int channels = 1;
    std::vector<std::uint8_t> pixels;  // width * height * channels
    // One value per pixel, 0 = transparent to 255 = opaque; empty = all pixels are opaque. Colours are not
    // premultiplied. Images made from others have no alpha, except the two views split from one file.
    std::vector<std::uint8_t> alpha = {};

    bool empty() const { return pixels.empty(); }
    const std::uint8_t* at(int x, int y) const {
        return pixels.data() + (static_cast<std::size_t>(y) * width + x) * channels;
    }
    std::uint8_t* at(int x, int y) {
        return pixels.data() + (static_cast<std::size_t>(y) * width + x) * channels;
    }
};

inline constexpr std::uint8_t kOpaque = 128;  // pixels with a smaller alpha count as transparent

}  // namespace hexrelief
