// 8-bit images as every stage sees them.
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
    // 0 = transparent to 255 = opaque, of each pixel; empty = all are opaque. The colours are not darkened by
    // it. What is made of an image has none, but for the views of a file that holds both.
    std::vector<std::uint8_t> alpha = {};

    bool empty() const { return pixels.empty(); }
    const std::uint8_t* at(int x, int y) const {
        return pixels.data() + (static_cast<std::size_t>(y) * width + x) * channels;
    }
    std::uint8_t* at(int x, int y) {
        return pixels.data() + (static_cast<std::size_t>(y) * width + x) * channels;
    }
};

inline constexpr std::uint8_t kOpaque = 128;  // alpha below this is transparent

}  // namespace hexrelief
