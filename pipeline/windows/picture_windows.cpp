#include "pipeline/windows/picture_windows.h"

#include "pipeline/readers/image_reader.h"

namespace hexrelief {

std::unique_ptr<PictureWindows> PictureWindows::open(const std::filesystem::path& path) {
    auto windows = std::make_unique<PictureWindows>();
    windows->whole_ = read_image(path);
    return windows;
}

Image PictureWindows::read(int x, int y, int width, int height) const {
    Image part{width, height, whole_.channels, {}};
    for (int row = y; row < y + height; ++row)
        part.pixels.insert(part.pixels.end(), whole_.at(x, row), whole_.at(x + width, row));
    return part;
}

}  // namespace hexrelief
