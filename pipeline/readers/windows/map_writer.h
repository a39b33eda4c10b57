// Writes float maps that do not fit into memory, row by row.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <vector>

#include "exporters/core/file_transaction.h"

namespace hexrelief::readers {

// The extension of the file's name is its format: .tif and .tiff are BigTIFF in square tiles, not compressed;
// .pfm is PFM. Both are little endian. Samples are written as they are, so unknown is +infinity.
class MapWriter {
  public:
    // Opens the file in `files`, which must outlive this object; the file appears when `files` is committed
    // after finish(). tile_px: 1 to 4096. Throws Error(usage) for another extension or a side above
    // kLargestMapSide_px, and Error(output) as FileTransaction::open() does.
    MapWriter(exporters::FileTransaction& files, const std::filesystem::path& path, int width, int height,
              int tile_px = 256);

    // Writes the next `count` rows, from the top; no more than the map has. Throws Error(output), for example
    // if the disk is full.
    void write(const float* rows, int count);
    // Completes the file; to be called after the last row. Throws Error(output).
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
    int row_ = 0;              // the next row
    std::uint64_t start_ = 0;  // offset of the samples
    std::vector<float> band_;  // a row of tiles, one after the other
};

}  // namespace hexrelief::readers
