// Images at a whole fraction of their size.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "pipeline/data/image.h"

namespace hexrelief {

// Returns an image of one over `by` of the size, rounded up, whose pixels are to be set; it has no alpha.
inline Image room_for_shrunk(const Image& image, int by) {
    const auto side = [by](int size) { return (size + by - 1) / by; };
    Image out{side(image.width), side(image.height), image.channels, {}};
    out.pixels.resize(static_cast<std::size_t>(out.width) * out.height * image.channels);
    return out;
}

// Sets rows [first, last) of the smaller image to the means over squares of by x by px, rounded; those at the
// right and lower edge cover what is left of the image.
inline void shrink_rows(const Image& image, int by, Image& out, int first, int last) {
    const auto channels = static_cast<std::size_t>(image.channels);
    std::vector<std::uint32_t> sums(static_cast<std::size_t>(image.width) * channels);  // of columns
    for (int y = first; y < last; ++y) {
        std::fill(sums.begin(), sums.end(), 0);
        const int rows = std::min(by, image.height - y * by);
        for (int row = y * by; row < y * by + rows; ++row) {
            const std::uint8_t* const values = image.at(0, row);
            std::uint32_t* const sum = sums.data();
            for (std::size_t i = 0, count = sums.size(); i < count; ++i) sum[i] += values[i];
        }
        const std::uint32_t* column = sums.data();
        std::uint8_t* mean = out.at(0, y);
        for (int x = 0; x < image.width; x += by) {
            const int columns = std::min(by, image.width - x);
            const auto pixels = static_cast<std::uint32_t>(rows * columns);
            for (std::size_t channel = 0; channel < channels; ++channel) {
                std::uint32_t sum = pixels / 2;
                for (int i = 0; i < columns; ++i)
                    sum += column[static_cast<std::size_t>(i) * channels + channel];
                *mean++ = static_cast<std::uint8_t>(sum / pixels);
            }
            column += static_cast<std::size_t>(columns) * channels;
        }
    }
}

inline Image shrunk(const Image& image, int by) {
    Image out = room_for_shrunk(image, by);
    shrink_rows(image, by, out, 0, out.height);
    return out;
}

}  // namespace hexrelief
