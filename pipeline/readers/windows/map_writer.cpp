#include "pipeline/readers/windows/map_writer.h"

#include <unistd.h>

#include <algorithm>
#include <bit>
#include <cassert>
#include <string>

#include "pipeline/data/error.h"
#include "pipeline/data/number_text.h"
#include "pipeline/readers/decoded_raster.h"
#include "pipeline/readers/windows/map_windows.h"

namespace hexrelief::readers {
namespace {

constexpr std::uint64_t kTiffHeaderBytes = 16;

bool is_tiff_name(const std::filesystem::path& path) {
    const std::string ending = path.extension().string();
    if (ending == ".pfm") return false;
    if (ending == ".tif" || ending == ".tiff") return true;
    throw Error(ErrorKind::usage,
                "cannot write a map as '" + path.string() + "'; let its name end in .tif, .tiff or .pfm");
}

void append(std::string& bytes, std::uint64_t value, int count) {
    for (int i = 0; i < count; ++i) bytes += static_cast<char>(value >> 8 * i & 0xff);
}

// Returns a TIFF's directory and the arrays of its tiles' offsets and sizes, for a file in which
// they begin at `at`.
std::string tiff_directory(std::uint64_t at, std::uint64_t width, std::uint64_t height, std::uint64_t tile_px,
                           std::uint64_t tiles) {
    struct Entry {
        std::uint16_t tag, type;  // 3 = 16 bits, 4 = 32 bits, 16 = 64 bits
        std::uint64_t count, value;
    };
    const std::uint64_t tile_bytes = 4 * tile_px * tile_px, entries = 12;
    const std::uint64_t numbers = at + 8 + 20 * entries + 8;  // after the directory
    const bool inside = tiles == 1;                           // a single number is stored in its entry
    const Entry all[entries] = {{256, 4, 1, width},
                                {257, 4, 1, height},
                                {258, 3, 1, 32},
                                {259, 3, 1, 1},  // not compressed
                                {262, 3, 1, 1},  // 0 is black
                                {277, 3, 1, 1},
                                {284, 3, 1, 1},
                                {322, 4, 1, tile_px},
                                {323, 4, 1, tile_px},
                                {324, 16, tiles, inside ? kTiffHeaderBytes : numbers},
                                {325, 16, tiles, inside ? tile_bytes : numbers + 8 * tiles},
                                {339, 3, 1, 3}};  // floats
    std::string bytes;
    append(bytes, entries, 8);
    for (const Entry& entry : all) {
        append(bytes, entry.tag, 2);
        append(bytes, entry.type, 2);
        append(bytes, entry.count, 8);
        append(bytes, entry.value, 8);
    }
    append(bytes, 0, 8);  // no other directory
    if (inside) return bytes;
    for (std::uint64_t i = 0; i < tiles; ++i) append(bytes, kTiffHeaderBytes + i * tile_bytes, 8);
    for (std::uint64_t i = 0; i < tiles; ++i) append(bytes, tile_bytes, 8);
    return bytes;
}

}  // namespace

MapWriter::MapWriter(exporters::FileTransaction& files, const std::filesystem::path& path, int width,
                     int height, int tile_px)
    : path_(path), width_(width), height_(height), tile_px_(tile_px), is_tiff_(is_tiff_name(path)) {
    assert(tile_px >= 1 && tile_px <= 4096);
    if (std::min(width, height) < 1 || std::max(width, height) > kLargestMapSide_px)
        throw Error(ErrorKind::usage, "a map's sides are 1 to " + std::to_string(kLargestMapSide_px) +
                                          " px, not " + size_text(width, height) + "; give another size");
    descriptor_ = files.open(path);
    const std::string header =
        is_tiff_ ? std::string(kTiffHeaderBytes, '\0')
                 : "Pf\n" + std::to_string(width) + " " + std::to_string(height) + "\n-1.0\n";
    start_ = header.size();
    write_at(0, header.data(), header.size());
    if (is_tiff_) band_.resize(tiles_across() * tile_px_ * tile_px_);
}

std::uint64_t MapWriter::tile_bytes() const {
    return std::uint64_t{4} * static_cast<unsigned>(tile_px_) * static_cast<unsigned>(tile_px_);
}

std::uint64_t MapWriter::tiles_across() const {
    return static_cast<std::uint64_t>((width_ + tile_px_ - 1) / tile_px_);
}

void MapWriter::write_at(std::uint64_t at, const void* data, std::size_t bytes) const {
    ::lseek(descriptor_, static_cast<off_t>(at), SEEK_SET);
    exporters::write_opened(descriptor_, path_, data, bytes);
}

void MapWriter::put_in_band(const float* row) {
    const std::size_t in_tile = static_cast<std::size_t>(row_ % tile_px_) * tile_px_;
    for (int x = 0; x < width_; x += tile_px_)
        std::copy_n(
            row + x, std::min(tile_px_, width_ - x),
            band_.begin() + static_cast<std::ptrdiff_t>(static_cast<std::size_t>(x) * tile_px_ + in_tile));
}

void MapWriter::write(const float* rows, int count) {
    assert(count <= height_ - row_);
    std::vector<float> swapped;
    for (int i = 0; i < count; ++i, ++row_) {
        const float* row = rows + static_cast<std::size_t>(i) * width_;
        if constexpr (std::endian::native == std::endian::big) {
            swapped.assign(row, row + width_);
            for (float& value : swapped) value = codec::in_other_byte_order(value);
            row = swapped.data();
        }
        const std::uint64_t row_bytes = std::uint64_t{4} * static_cast<unsigned>(width_);
        if (!is_tiff_) {
            write_at(start_ + static_cast<unsigned>(height_ - 1 - row_) * row_bytes, row, row_bytes);
            continue;
        }
        put_in_band(row);
        const std::uint64_t band_bytes = tiles_across() * tile_bytes();
        if ((row_ + 1) % tile_px_ == 0 || row_ + 1 == height_)
            write_at(start_ + static_cast<unsigned>(row_ / tile_px_) * band_bytes, band_.data(), band_bytes);
    }
}

void MapWriter::finish() {
    assert(row_ == height_);
    if (!is_tiff_) return;
    const auto bands = static_cast<std::uint64_t>((height_ + tile_px_ - 1) / tile_px_);
    const std::uint64_t tiles = tiles_across() * bands, at = start_ + tiles * tile_bytes();
    const std::string directory =
        tiff_directory(at, static_cast<unsigned>(width_), static_cast<unsigned>(height_),
                       static_cast<unsigned>(tile_px_), tiles);
    write_at(at, directory.data(), directory.size());
    std::string header = "II";
    append(header, 43, 2);  // BigTIFF
    append(header, 8, 2);   // bytes of an offset
    append(header, 0, 2);
    append(header, at, 8);
    write_at(0, header.data(), header.size());
}

}  // namespace hexrelief::readers
