// TIFF files by libtiff, wherever their bytes are: what a picture is, and its samples as they are stored.
#pragma once

#include <tiffio.h>

#include <functional>
#include <memory>

#include "pipeline/readers/decoded_raster.h"
#include "pipeline/readers/source.h"

namespace hexrelief::readers::codec {

// What libtiff reads, and its first complaint. It serves one thread at a time.
struct TiffSource {
    const std::filesystem::path& path;
    std::uint64_t bytes;  // of the file
    // Copies `count` bytes from `at`, which the file has; false where it does not give them any more.
    std::function<bool(std::uint64_t at, void* to, std::size_t count)> copy;
    std::uint64_t position = 0;
    char message[200] = "";
};

struct TiffCloser {
    void operator()(TIFF* tiff) const { TIFFClose(tiff); }
};
using TiffHandle = std::unique_ptr<TIFF, TiffCloser>;

// The first picture of the file. The source must outlive the handle. These functions throw Error(input) with
// libtiff's complaint.
TiffHandle open_tiff(TiffSource& source);
[[noreturn]] void refuse_malformed(const TiffSource& source);

struct TiffLayout {
    std::uint32_t width = 0, height = 0;
    std::uint16_t samples = 1;  // a pixel, with extras
    std::uint16_t bits = 1;
    std::uint16_t format = SAMPLEFORMAT_UINT;
    std::uint16_t photometric = PHOTOMETRIC_MINISBLACK;
    std::uint16_t compression = COMPRESSION_NONE;
    bool planes = false;  // one plane a sample instead of interleaved
    bool alpha = false;   // the sample after the colours is one

    int channels() const { return (photometric == PHOTOMETRIC_RGB ? 3 : 1) + alpha; }
    unsigned long long row_bytes() const {  // of one plane or of the interleaved row
        return (static_cast<unsigned long long>(width) * (planes ? 1 : samples) * bits + 7) / 8;
    }
};

// Of a size that nobody has looked at.
TiffLayout read_layout(TIFF* tiff, const TiffSource& source);
// Grey or RGB: neither palettes nor YCbCr nor inks.
bool stored_plainly(const TiffLayout& layout);
// Refuses samples other than unsigned ones of up to 16 bits and floats of 32 or 64.
void check_samples(const TiffLayout& layout, const TiffSource& source);
// GDAL's tag; NaN where there is none.
double nodata_of(TIFF* tiff);

// The samples of a window within a picture that is stored plainly, all its channels. Memory: the window,
// which grows with what has been decoded, and a tile, or a row and a strip as it is stored. Throws
// Error(input) for samples other than unsigned ones of up to 16 bits and floats of 32 or 64, and for what is
// damaged.
Raster read_plainly(TIFF* tiff, const TiffLayout& layout, TiffSource& source, const PixelWindow& window);

}  // namespace hexrelief::readers::codec
