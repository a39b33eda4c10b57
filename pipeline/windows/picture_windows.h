// Windows of pictures that do not fit into memory.
#pragma once

#include <filesystem>
#include <memory>

#include "pipeline/data/image.h"
#include "pipeline/readers/limits.h"

namespace hexrelief::windows {

class WindowSource;

// A picture's file of which any window can be read, by any number of threads. Of TIFF and BigTIFF in grey or
// RGB, with alpha or not, in tiles or strips, and of binary PGM and PPM, windows alone are read, and a side
// may have kLargestMapSide_px (map_windows.h). Pictures in other formats, and TIFF's palettes, YCbCr and
// inks, are held as a whole, within read_image()'s limits.
class PictureWindows {
  public:
    // limits: of pictures that are held as a whole. Throws Error(input) as read_image().
    static std::unique_ptr<PictureWindows> open(const std::filesystem::path& path,
                                                const readers::ReaderLimits& limits = {});
    ~PictureWindows();

    int width() const;
    int height() const;
    int channels() const;    // 1 or 3
    bool has_alpha() const;  // some pixels may be transparent
    // The same pixels as a crop of read_image()'s; alpha is kept where some pixel's of the window is below
    // half. Memory: the window, its samples besides, and a tile; of compressed strips a row, and a strip as
    // it is stored. Throws Error(input) for a window that is empty, not within the picture or above
    // kMaxPixels, and for what is damaged or truncated there.
    Image read(int x, int y, int width, int height) const;

  private:
    PictureWindows(std::filesystem::path path, const readers::ReaderLimits& limits);
    std::filesystem::path path_;
    std::unique_ptr<WindowSource> source_;
};

}  // namespace hexrelief::windows
