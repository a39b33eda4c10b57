// Reads windows of disparity maps and of pictures that do not fit into memory.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "pipeline/data/disparity_map.h"
#include "pipeline/data/image.h"
#include "pipeline/readers/decoded_raster.h"
#include "pipeline/readers/disparity_reader.h"
#include "pipeline/readers/limits.h"

namespace hexrelief::readers {

// The largest width or height: beyond it, floats cannot resolve half a pixel of a coordinate.
inline constexpr int kLargestMapSide_px = 1 << 23;

enum class MapSample { uint8, uint16, float32 };

// The layout of a file that has only samples, row after row, top row first.
struct RawMapLayout {
    int width = 0, height = 0;
    MapSample sample = MapSample::float32;  // or uint16
    bool is_big_endian = false;
};

// Parses "WIDTHxHEIGHT,TYPE". TYPE is float32, uint16, float32be or uint16be; without "be" the lowest byte of
// a sample comes first. Throws Error(usage).
RawMapLayout parse_raw_map_layout(const std::string& text);

struct MapWindowConfig {
    DisparityFileConfig disparity = {};    // meaning of the samples, as for maps that are read whole
    std::optional<RawMapLayout> raw = {};  // none = TIFF, BigTIFF or PFM, recognised by content
};

// What MapWindows and PictureWindows convert to disparities or colours.
class WindowSource {
  public:
    WindowSource() = default;
    WindowSource(const WindowSource&) = delete;
    WindowSource& operator=(const WindowSource&) = delete;
    virtual ~WindowSource() = default;

    int width = 0, height = 0;
    int channels = 1;  // without alpha
    bool has_alpha = false;
    MapSample sample = MapSample::float32;
    // Reads a window within the file's pixels; a map's has one channel. Any number of threads may read.
    virtual codec::Raster read(const codec::PixelWindow& window) const = 0;
};

// A file of pixels of which any window can be read.
class FileWindows {
  public:
    int width() const { return source_->width; }
    int height() const { return source_->height; }

  protected:
    FileWindows(std::filesystem::path path, std::unique_ptr<WindowSource> source)
        : path_(std::move(path)), source_(std::move(source)) {}
    std::filesystem::path path_;
    std::unique_ptr<WindowSource> source_;
};

// A map file of which any window can be read. Several threads may read at once: rows are read by position
// from one descriptor, and each thread in a TIFF's tiles has its own libtiff handle.
class MapWindows : public FileWindows {
  public:
    // Opens a map and reads its header; of float maps in rows also 256 x 256 px in the middle, to check the
    // byte order. TIFF: samples of one channel, of the kinds that read_disparity_map() accepts; in tiles or
    // strips, compressed or not, with GDAL's nodata. Throws Error(input) as read_disparity_map() does, except
    // that a map may have any size up to kLargestMapSide_px a side, and only unknown pixels.
    static std::unique_ptr<MapWindows> open(const std::filesystem::path& path,
                                            const MapWindowConfig& config = {});
    // Returns the same pixels as a crop of read_disparity_map()'s map. Memory: the window, for integers also
    // its samples, and a tile; for compressed strips a row, and a strip as stored. Throws Error(input) if the
    // window is empty, not within the map or above kMaxPixels, or if the file is damaged or truncated there.
    DisparityMap read(int x, int y, int width, int height) const;

  private:
    MapWindows(const std::filesystem::path& path, const MapWindowConfig& config);
    DisparityFileConfig config_;
};

// A picture's file of which any window can be read, by any number of threads. Only the window is read from
// TIFF and BigTIFF in grey or RGB, with or without alpha, in tiles or strips, and from binary PGM and PPM; a
// side may have up to kLargestMapSide_px. Pictures in other formats, and TIFF with palettes,
// YCbCr or inks, are held in memory as a whole, within read_image()'s limits.
class PictureWindows : public FileWindows {
  public:
    // Opens a picture. limits: for pictures that are held as a whole. Throws
    // Error(input) as read_image() does.
    static std::unique_ptr<PictureWindows> open(const std::filesystem::path& path,
                                                const ReaderLimits& limits = {});
    int channels() const { return source_->channels; }     // 1 or 3
    bool has_alpha() const { return source_->has_alpha; }  // some pixels may be transparent
    // Returns the same pixels as a crop of read_image()'s picture; alpha is kept if it is below half at some
    // pixel of the window. Memory: the window, its samples, and a tile; for compressed strips a row, and a
    // strip as stored. Throws Error(input) if the window is empty, not within the picture or above
    // kMaxPixels, or if the file is damaged or truncated there.
    Image read(int x, int y, int width, int height) const;
    // Returns the means over squares of by x by px of a window, which may end within a square; x and y are
    // multiples of `by`. Memory: the result, and a band of the window.
    Image read_shrunk(int x, int y, int width, int height, int by) const;

  private:
    using FileWindows::FileWindows;
};

}  // namespace hexrelief::readers
