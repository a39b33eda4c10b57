// Windows of pictures.
#pragma once

#include <filesystem>
#include <memory>

#include "pipeline/data/image.h"

namespace hexrelief {

// Any number of threads may read.
class PictureWindows {
  public:
    // Throws Error(input) as read_image().
    static std::unique_ptr<PictureWindows> open(const std::filesystem::path& path);

    int width() const { return whole_.width; }
    int height() const { return whole_.height; }
    // The same pixels as a crop of read_image()'s.
    Image read(int x, int y, int width, int height) const;

  private:
    Image whole_;
};

}  // namespace hexrelief
