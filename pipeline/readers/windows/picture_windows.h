// Reads windows of pictures that do not fit into memory.
#pragma once

#include <filesystem>
#include <memory>

#include "pipeline/data/image.h"
#include "pipeline/readers/limits.h"

namespace hexrelief::readers {

class WindowSource;

// A picture's file of which any window can be read, by any number of threads. Only the window is read from
// TIFF and BigTIFF in grey or RGB, with or without alpha, in tiles or strips, and from binary PGM and PPM; a
// side may have up to kLargestMapSide_px (map_windows.h). Pictures in other formats, and TIFF with palettes,
// YCbCr or inks, are held in memory as a whole, within read_image()'s limits.
class PictureWindows {
  public:
    // Opens a picture. limits: for pictures that are held as a whole. Throws
    // Error(input) as read_image() does.
    static std::unique_ptr<PictureWindows> open(const std::filesystem::path& path,
                                                const readers::ReaderLimits& limits = {});
    ~PictureWindows();

    int width() const;
    int height() const;
    int channels() const;    // 1 or 3
    bool has_alpha() const;  // some pixels may be transparent
    // Returns the same pixels as a crop of read_image()'s picture; alpha is kept if it is below half at some
    // pixel of the window. Memory: the window, its samples, and a tile; for compressed strips a row, and a
    // strip as stored. Throws Error(input) if the window is empty, not within the picture or above
    // kMaxPixels, or if the file is damaged or truncated there.
    Image read(int x, int y, int width, int height) const;

  private:
    PictureWindows(std::filesystem::path path, const readers::ReaderLimits& limits);
    std::filesystem::path path_;
    std::unique_ptr<WindowSource> source_;
};

}  // namespace hexrelief::readers
