// Float maps that do not fit into memory, written row by row.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <vector>

#include "exporters/core/file_transaction.h"

namespace hexrelief::windows {

// The name's ending is the format: .tif and .tiff are BigTIFF in square tiles, not compressed; .pfm is PFM.
// Both are little endian; samples are written as they are, so that unknown is +infinity.
class MapWriter {
  public:
    // Writes nothing before write(), and the file appears when `files`, which must outlive this, is committed
    // after finish(). tile_px: 1 to 4096. Throws Error(usage) for another ending, and a size beyond
    // kLargestMapSide_px; Error(output) as FileTransaction::open().
    MapWriter(exporters::FileTransaction& files, const std::filesystem::path& path, int width, int height,
              int tile_px = 256);

    // The next `count` rows, from the top; no more than the map has. Throws Error(output): a full disk.
    void write(const float* rows, int count);
    // To be called after the last row. Throws likewise.
    void finish();

  private:
    void write_at(std::uint64_t at, const void* data, std::size_t bytes) const;
    void put_in_band(const float* row);
    std::uint64_t tile_bytes() const;
    std::uint64_t tiles_across() const;

    std::filesystem::path path_;
    int width_, height_, tile_px_;
    bool is_tiff_;
    int descriptor_ = -1;
    int row_ = 0;              // the next one
    std::uint64_t start_ = 0;  // of the samples
    std::vector<float> band_;  // a row of tiles, one after the other
};

}  // namespace hexrelief::windows
