// Sources of sample windows, by format.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>

#include "pipeline/readers/decoded_raster.h"
#include "pipeline/readers/windows/map_windows.h"

namespace hexrelief::readers {

// A regular file, read by position, by any number of threads. Functions throw Error(input).
class MapFile {
  public:
    explicit MapFile(const std::filesystem::path& path);
    MapFile(const MapFile&) = delete;
    MapFile& operator=(const MapFile&) = delete;
    ~MapFile();

    const std::filesystem::path& path() const { return path_; }
    std::uint64_t bytes() const { return bytes_; }
    // Copies bytes; false if the file ends before.
    bool copy(std::uint64_t at, void* to, std::size_t count) const;

  private:
    std::filesystem::path path_;
    std::uint64_t bytes_ = 0;
    int descriptor_ = -1;
};

// The layout of rows of plain samples, which may begin anywhere in the file.
struct RowLayout {
    int width = 0, height = 0;
    MapSample sample = MapSample::float32;
    int channels = 1;          // interleaved
    unsigned max_value = 255;  // of integers
    bool is_big_endian = false;
    std::function<std::uint64_t(std::uint32_t y)> row_at;
    double nodata = codec::kNoData;
};
std::unique_ptr<WindowSource> row_windows(std::shared_ptr<const MapFile> file, RowLayout layout);

// Open a file by its header. Throw Error(input) if it is malformed or truncated.
std::unique_ptr<WindowSource> pfm_windows(std::shared_ptr<const MapFile> file);
std::unique_ptr<WindowSource> raw_windows(std::shared_ptr<const MapFile> file, const RawMapLayout& layout);
std::unique_ptr<WindowSource> tiff_windows(std::shared_ptr<const MapFile> file);
// Open pictures. tiff_picture_windows() returns null for a TIFF whose pixels are neither grey nor RGB, which
// libtiff has to convert.
std::unique_ptr<WindowSource> tiff_picture_windows(std::shared_ptr<const MapFile> file);
std::unique_ptr<WindowSource> pnm_windows(std::shared_ptr<const MapFile> file);

// Refuses sides of 0 and of more than kLargestMapSide_px.
void check_map_size(const std::filesystem::path& path, unsigned long long width, unsigned long long height);

struct WantedWindow {
    int x, y, width, height;
};
// Reads a window. Throws Error(input) naming `path` if the window is empty, not within the file's pixels or
// above kMaxPixels, or if the file is damaged or truncated there.
codec::Raster read_window(const WindowSource& source, const std::filesystem::path& path,
                          const WantedWindow& window);
// Returns a window without pixels, by which a file's kind of samples is checked before it is read.
codec::Raster no_samples(const WindowSource& source);

}  // namespace hexrelief::readers
