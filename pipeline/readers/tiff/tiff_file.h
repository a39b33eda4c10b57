// Reads TIFF files by libtiff, from a file or from memory: a picture's layout, and its samples as stored.
#pragma once

#include <tiffio.h>

#include <functional>
#include <memory>

#include "pipeline/readers/decoded_raster.h"
#include "pipeline/readers/source.h"

namespace hexrelief::readers::codec {

// The input of libtiff, and its first error message. May only be used by one thread at a time.
struct TiffSource {
    const std::filesystem::path& path;
    std::uint64_t bytes;  // size of the file
    // Copies `count` bytes at offset `at`, which must lie in the file; false if they cannot be read.
    std::function<bool(std::uint64_t at, void* to, std::size_t count)> copy;
    std::uint64_t position = 0;
    char message[200] = "";
};

struct TiffCloser {
    void operator()(TIFF* tiff) const { TIFFClose(tiff); }
};
using TiffHandle = std::unique_ptr<TIFF, TiffCloser>;

// Opens the first picture of the file. The source must outlive the handle. This and the functions below throw
// Error(input) with libtiff's message.
TiffHandle open_tiff(TiffSource& source);
[[noreturn]] void refuse_malformed(const TiffSource& source);

struct TiffLayout {
    std::uint32_t width = 0, height = 0;
    std::uint16_t samples = 1;  // per pixel, with extra samples
    std::uint16_t bits = 1;
    std::uint16_t format = SAMPLEFORMAT_UINT;
    std::uint16_t photometric = PHOTOMETRIC_MINISBLACK;
    std::uint16_t compression = COMPRESSION_NONE;
    bool planes = false;  // one plane per sample instead of interleaved samples
    bool alpha = false;   // the sample after the colours is alpha

    int channels() const { return (photometric == PHOTOMETRIC_RGB ? 3 : 1) + alpha; }
    unsigned long long row_bytes() const {  // one row of one plane, or of the interleaved samples
        return (static_cast<unsigned long long>(width) * (planes ? 1 : samples) * bits + 7) / 8;
    }
};

// Reads the layout; the picture's size is not checked.
TiffLayout read_layout(TIFF* tiff, const TiffSource& source);
// True for grey or RGB; false for palettes, YCbCr and inks.
bool stored_plainly(const TiffLayout& layout);
// True for signed integers, and for unsigned ones of 32 bits, which are read as floats unless they fit 16
// bits.
bool are_wide_integers(const TiffLayout& layout);
// Refuses samples other than integers of up to 32 bits and floats of 16 to 64.
void check_samples(const TiffLayout& layout, const TiffSource& source);
// Returns GDAL's nodata tag; NaN if there is none.
double nodata_of(TIFF* tiff);
// Returns the picture's colour profile; empty if it has none.
std::vector<std::uint8_t> profile_of(TIFF* tiff);

// Returns the samples of a window of a picture that is stored plainly, with all its channels. Memory: the
// window, which grows with what has been decoded, and a tile, or a row and a strip as stored. Throws
// Error(input) for samples that check_samples() refuses and for damaged files.
Raster read_plainly(TIFF* tiff, const TiffLayout& layout, TiffSource& source, const PixelWindow& window);

}  // namespace hexrelief::readers::codec
