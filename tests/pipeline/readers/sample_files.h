// Makes the files that the readers' tests read.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "tests/expect_error.h"
#include "tests/temporary_folder.h"

namespace hexrelief::readers {

using Bytes = std::vector<std::uint8_t>;

class Folder : public test::Folder {
  public:
    std::filesystem::path write(const std::string& name, const Bytes& bytes) const;
    std::filesystem::path write(const std::string& name, std::string_view text) const;
};

Bytes read_bytes(const std::filesystem::path& path);
Bytes to_bytes(std::string_view text);
// Returns the text with the first `from`, which must be there, replaced.
std::string replaced(std::string text, const std::string& from, const std::string& to);
Bytes operator+(Bytes left, const Bytes& right);

struct PngKind {
    int bits = 8;
    int colour_type = 0;  // PNG's: 0 grey, 2 RGB, 3 palette, 4 grey alpha, 6 RGBA
    bool interlaced = false;
    Bytes palette = {};        // RGB triples
    Bytes palette_alpha = {};  // tRNS
};
// Makes a PNG. rows: the packed rows one after the other, 16-bit samples big endian.
Bytes make_png(int width, int height, const Bytes& rows, const PngKind& kind);

enum class JpegKind { grey, rgb, rgb_progressive, cmyk };
Bytes make_jpeg(int width, int height, const Bytes& samples, JpegKind kind);

Bytes make_webp(int width, int height, const Bytes& rgba, bool lossless);

struct TiffKind {
    int samples = 1;
    int bits = 8;
    int format = 1;       // SAMPLEFORMAT_UINT; 2 = INT, 3 = IEEEFP
    int photometric = 1;  // MINISBLACK; 0 = MINISWHITE, 2 = RGB, 3 = palette, 5 = separated (CMYK)
    int compression = 1;  // NONE; 5 = LZW, 8 = deflate
    int tile = 0;         // side of square tiles, 0 = strips
    bool planes = false;
    bool big_endian = false;
    int orientation = 1;
    Bytes profile = {};       // ICC; empty = no tag
    std::string nodata = {};  // text of GDAL's tag; empty = no tag
};
// Makes a TIFF. rows: as stored, in the machine's byte order; one plane after the other if kind.planes.
Bytes make_tiff(int width, int height, const Bytes& rows, const TiffKind& kind);

template <typename Sample>
Bytes bytes_of(const std::vector<Sample>& samples) {
    const auto* first = reinterpret_cast<const std::uint8_t*>(samples.data());
    return Bytes(first, first + samples.size() * sizeof(Sample));
}

Bytes make_pgm(int width, int height, int max_value, const Bytes& samples, char kind = '5');
// Makes a PFM. values: bottom row first, as in the file.
Bytes make_pfm(int width, int height, const std::vector<float>& values, bool little_endian = true);

using test::error_of;

// Returns the error of reading a file with these contents; it names the file.
template <typename Contents, typename Read>
std::string error_of_file(const std::string& name, const Contents& contents, const Read& read) {
    const Folder folder;
    const std::filesystem::path path = folder.write(name, contents);
    const std::string message = error_of([&] { read(path); });
    EXPECT_CONTAINS(message, name);
    return message;
}

// Returns the peak memory, in MiB, of a process that does the work, which must not throw.
long peak_memory_MiB(const std::function<void()>& work);

}  // namespace hexrelief::readers
