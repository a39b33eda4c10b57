// Windows of disparity maps that do not fit into memory.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "pipeline/data/disparity_map.h"
#include "pipeline/readers/disparity_reader.h"

namespace hexrelief::windows {

// Beyond, floats no longer tell half a pixel of a coordinate.
inline constexpr int kLargestMapSide_px = 1 << 23;

enum class MapSample { uint8, uint16, float32 };

// A file of samples alone, row after row, top row first.
struct RawMapLayout {
    int width = 0, height = 0;
    MapSample sample = MapSample::float32;  // or uint16
    bool is_big_endian = false;
};

// "WIDTHxHEIGHT,TYPE", where TYPE is float32, uint16, float32be or uint16be; without "be" the lowest byte of
// a sample comes first. Throws Error(usage).
RawMapLayout parse_raw_map_layout(const std::string& text);

struct MapWindowConfig {
    readers::DisparityFileConfig disparity = {};  // what samples mean, as in maps that are read whole
    std::optional<RawMapLayout> raw = {};         // none = TIFF, BigTIFF or PFM, by content
};

class WindowSource;

// A map file of which any window can be read. All of it serves several threads at once: rows are read by
// position from one descriptor, and each thread in a TIFF's tiles has a libtiff handle of its own.
class MapWindows {
  public:
    // Reads the header, and of maps of float rows 256 x 256 px in the middle, which tell the byte order.
    // TIFF: the samples that read_disparity_map() takes, of one channel; in tiles or strips, compressed or
    // not, with GDAL's nodata. Throws Error(input): as read_disparity_map() does, but a map may be of any
    // size up to kLargestMapSide_px a side, and of unknown pixels only.
    static std::unique_ptr<MapWindows> open(const std::filesystem::path& path,
                                            const MapWindowConfig& config = {});
    ~MapWindows();

    int width() const;
    int height() const;
    // The same pixels as a crop of read_disparity_map()'s. Memory: the window, integers' samples besides, and
    // a tile; of compressed strips a row, and a strip as it is stored. Throws Error(input) for a window that
    // is empty, not within the map or above kMaxPixels, and for what is damaged or truncated there.
    DisparityMap read(int x, int y, int width, int height) const;

  private:
    MapWindows(std::filesystem::path path, const MapWindowConfig& config);
    std::filesystem::path path_;
    readers::DisparityFileConfig config_;
    std::unique_ptr<WindowSource> source_;
};

}  // namespace hexrelief::windows
