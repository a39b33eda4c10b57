#include "pipeline/tiles/shrunk_picture.h"

#include <algorithm>
#include <cstdint>

namespace hexrelief::tiles {

Image shrunk_picture(const windows::PictureWindows& picture, const mesh_tiles::MapRect& part, int by) {
    const auto shrunk = [by](int size) { return (size + by - 1) / by; };
    Image out{shrunk(part.width), shrunk(part.height), 1, {}};
    const int band_rows = std::max(by, (1 << 24) / std::max(1, part.width) / by * by);
    std::vector<std::uint32_t> sums;
    for (int y = 0; y < part.height; y += band_rows) {
        const Image band = picture.read(part.x, part.y + y, part.width, std::min(band_rows, part.height - y));
        out.channels = band.channels;
        for (int top = 0; top < band.height; top += by) {
            const int rows = std::min(by, band.height - top);
            sums.assign(static_cast<std::size_t>(out.width) * band.channels, 0);
            for (int row = top; row < top + rows; ++row)
                for (int x = 0; x < band.width; ++x)
                    for (int k = 0; k < band.channels; ++k)
                        sums[static_cast<std::size_t>(x / by) * band.channels + k] += band.at(x, row)[k];
            for (int x = 0; x < out.width; ++x) {
                const auto pixels = static_cast<std::uint32_t>(rows * std::min(by, band.width - x * by));
                for (int k = 0; k < band.channels; ++k)
                    out.pixels.push_back(static_cast<std::uint8_t>(
                        (sums[static_cast<std::size_t>(x) * band.channels + k] + pixels / 2) / pixels));
            }
        }
    }
    return out;
}

}  // namespace hexrelief::tiles
