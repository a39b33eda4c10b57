// TIFF through libtiff: the first picture of the file. Grey and RGB samples are read as they are stored,
// because a map means the number itself and alpha must not darken a colour; everything else (palettes, YCbCr,
// CMYK) goes through libtiff's own conversion to 8-bit RGB. The orientation tag is ignored.
#include <tiffio.h>

#include <algorithm>
#include <cstdarg>
#include <cstdio>
#include <cstring>
#include <memory>
#include <type_traits>

#include "pipeline/readers/codecs.h"
#include "pipeline/readers/text.h"

namespace hexrelief::codec {
namespace {

// libtiff's view of the bytes, and its first complaint.
struct TiffSource {
    const SourceFile& file;
    std::uint64_t position = 0;
    char message[200] = "";
};

TiffSource& source_of(thandle_t handle) {
    return *static_cast<TiffSource*>(handle);
}

tmsize_t on_read(thandle_t handle, void* to, tmsize_t count) {
    TiffSource& source = source_of(handle);
    const std::uint64_t size = source.file.bytes.size();
    const std::uint64_t left = source.position < size ? size - source.position : 0;
    const std::uint64_t got =
        std::min<std::uint64_t>(left, static_cast<std::uint64_t>(std::max<tmsize_t>(count, 0)));
    if (got > 0) std::memcpy(to, source.file.bytes.data() + source.position, got);
    source.position += got;
    return static_cast<tmsize_t>(got);
}

tmsize_t on_write(thandle_t, void*, tmsize_t) {
    return 0;
}

toff_t on_seek(thandle_t handle, toff_t offset, int whence) {
    TiffSource& source = source_of(handle);
    if (whence == SEEK_CUR) offset += source.position;
    if (whence == SEEK_END) offset += source.file.bytes.size();
    return source.position = offset;
}

int on_close(thandle_t) {
    return 0;
}
toff_t on_size(thandle_t handle) {
    return source_of(handle).file.bytes.size();
}

// Nonzero: handled, so that libtiff's global handler prints nothing.
int on_error(TIFF*, void* user, const char*, const char* format, va_list arguments) {
    auto& source = *static_cast<TiffSource*>(user);
    if (source.message[0] == '\0') std::vsnprintf(source.message, sizeof source.message, format, arguments);
    return 1;
}

int on_warning(TIFF*, void*, const char*, const char*, va_list) {
    return 1;
}

struct TiffCloser {
    void operator()(TIFF* tiff) const { TIFFClose(tiff); }
};
using TiffHandle = std::unique_ptr<TIFF, TiffCloser>;

struct OptionsFreer {
    void operator()(TIFFOpenOptions* options) const { TIFFOpenOptionsFree(options); }
};

[[noreturn]] void refuse_malformed(const TiffSource& source) {
    const char* reason = source.message[0] ? source.message : "damaged or truncated";
    refuse(source.file.path, std::string("malformed TIFF: ") + reason + "; copy or export it again");
}

TiffHandle open(TiffSource& source) {
    const std::unique_ptr<TIFFOpenOptions, OptionsFreer> options(TIFFOpenOptionsAlloc());
    if (!options) refuse(source.file.path, "libtiff could not be started (out of memory)");
    // A damaged tag can ask for any amount; a strip of the largest picture is the most that is ever right.
    TIFFOpenOptionsSetMaxSingleMemAlloc(options.get(), static_cast<tmsize_t>(1) << 33);
    TIFFOpenOptionsSetErrorHandlerExtR(options.get(), on_error, &source);
    TIFFOpenOptionsSetWarningHandlerExtR(options.get(), on_warning, nullptr);
    // m: no memory mapping, the bytes are copied strip by strip
    TiffHandle tiff(TIFFClientOpenExt("file", "rm", &source, on_read, on_write, on_seek, on_close, on_size,
                                      nullptr, nullptr, options.get()));
    if (!tiff) refuse_malformed(source);
    return tiff;
}

struct Layout {
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

Layout read_layout(TIFF* tiff, const TiffSource& source) {
    Layout layout;
    TIFFGetField(tiff, TIFFTAG_IMAGEWIDTH, &layout.width);
    TIFFGetField(tiff, TIFFTAG_IMAGELENGTH, &layout.height);
    TIFFGetFieldDefaulted(tiff, TIFFTAG_SAMPLESPERPIXEL, &layout.samples);
    TIFFGetFieldDefaulted(tiff, TIFFTAG_BITSPERSAMPLE, &layout.bits);
    TIFFGetFieldDefaulted(tiff, TIFFTAG_SAMPLEFORMAT, &layout.format);
    TIFFGetFieldDefaulted(tiff, TIFFTAG_COMPRESSION, &layout.compression);
    std::uint16_t planar = PLANARCONFIG_CONTIG;
    TIFFGetFieldDefaulted(tiff, TIFFTAG_PLANARCONFIG, &planar);
    layout.planes = planar == PLANARCONFIG_SEPARATE && layout.samples > 1;
    if (!TIFFGetField(tiff, TIFFTAG_PHOTOMETRIC, &layout.photometric)) {  // some writers leave it out
        layout.photometric = layout.samples >= 3 ? PHOTOMETRIC_RGB : PHOTOMETRIC_MINISBLACK;
    }
    std::uint16_t extras = 0;
    const std::uint16_t* kinds = nullptr;
    TIFFGetFieldDefaulted(tiff, TIFFTAG_EXTRASAMPLES, &extras, &kinds);
    layout.alpha = extras > 0 && kinds[0] != EXTRASAMPLE_UNSPECIFIED && layout.samples > layout.channels() &&
                   (layout.bits == 8 || layout.bits == 16) && layout.format == SAMPLEFORMAT_UINT &&
                   layout.photometric != PHOTOMETRIC_MINISWHITE;
    check_size(source.file, layout.width, layout.height);
    if (layout.samples < 1 || layout.samples > 16) {
        refuse(source.file.path,
               "it has " + std::to_string(layout.samples) + " samples a pixel; save it as grey or RGB");
    }
    return layout;
}

bool stored_plainly(const Layout& layout) {
    return layout.photometric == PHOTOMETRIC_MINISBLACK || layout.photometric == PHOTOMETRIC_MINISWHITE ||
           (layout.photometric == PHOTOMETRIC_RGB && layout.samples >= 3);
}

// What GDAL writes: a number as text.
double nodata_of(TIFF* tiff) {
    constexpr std::uint32_t tag = 42113;
    std::uint32_t count = 0;
    void* text = nullptr;
    if (!TIFFGetField(tiff, tag, &count, &text) || text == nullptr) return kNoData;
    const TIFFField* const field = TIFFFieldWithTag(tiff, tag);
    if (field == nullptr || TIFFFieldDataType(field) != TIFF_ASCII) return kNoData;
    std::string_view number(static_cast<const char*>(text), count);
    return parse_number(number.substr(0, number.find('\0'))).value_or(kNoData);
}

void check_samples(const Layout& layout, const TiffSource& source) {
    const bool whole = layout.format == SAMPLEFORMAT_UINT || layout.format == SAMPLEFORMAT_VOID;
    const bool real = layout.format == SAMPLEFORMAT_IEEEFP;
    if (whole &&
        (layout.bits == 1 || layout.bits == 2 || layout.bits == 4 || layout.bits == 8 || layout.bits == 16)) {
        return;
    }
    if (real && (layout.bits == 32 || layout.bits == 64)) return;
    refuse(source.file.path, "its TIFF samples are " + std::to_string(layout.bits) + "-bit " +
                                 (whole  ? "unsigned"
                                  : real ? "float"
                                         : "signed or complex") +
                                 "; save it as 8 or 16-bit unsigned or 32-bit float");
}

// The compressions whose best ratio is known are held against the file's length before memory is asked for.
void check_promise(const Layout& layout, const TiffSource& source) {
    const unsigned long long bytes =
        layout.row_bytes() * layout.height * (layout.planes ? layout.channels() : 1);
    switch (layout.compression) {
        case COMPRESSION_NONE:
            return check_length(source.file, bytes, 1);
        case COMPRESSION_PACKBITS:
            return check_length(source.file, bytes, 128);
        case COMPRESSION_LZW:
        case COMPRESSION_DEFLATE:
        case COMPRESSION_ADOBE_DEFLATE:
            return check_length(source.file, bytes, 4096);
        default:
            return;
    }
}

template <typename Stored>
Stored stored_at(const std::uint8_t* row, std::size_t index) {
    Stored value;
    std::memcpy(&value, row + index * sizeof(Stored), sizeof(Stored));
    return value;
}

// libtiff has already turned the bytes into the machine's order.
template <typename Sample>
Sample sample_at(const std::uint8_t* row, std::size_t index, unsigned bits) {
    if constexpr (std::is_same_v<Sample, float>) {
        return bits == 64 ? static_cast<float>(stored_at<double>(row, index)) : stored_at<float>(row, index);
    } else {
        if (bits == 8 * sizeof(Sample)) return stored_at<Sample>(row, index);
        const std::size_t bit = index * bits;
        return static_cast<Sample>(row[bit / 8] >> (8 - bits - bit % 8) & ((1u << bits) - 1));
    }
}

template <typename Sample>
class PlainReader {
  public:
    PlainReader(TIFF* tiff, const Layout& layout, TiffSource& source)
        : tiff_(tiff), layout_(layout), source_(source) {}

    std::vector<Sample> read() {
        const int planes = layout_.planes ? layout_.channels() : 1;
        for (int plane = 0; plane < planes; ++plane) {
            if (TIFFIsTiled(tiff_)) {
                read_tiles(plane);
            } else {
                read_rows(plane);
            }
        }
        return std::move(samples_);
    }

  private:
    void read_rows(int plane) {
        const auto bytes = static_cast<std::size_t>(TIFFScanlineSize64(tiff_));
        if (bytes < layout_.row_bytes()) refuse_malformed(source_);
        if (bytes > (std::size_t{1} << 33)) refuse(source_.file.path, "its rows are too long; crop it first");
        const std::unique_ptr<std::uint8_t[]> row(new std::uint8_t[bytes]);  // not touched before it is read
        for (std::uint32_t y = 0; y < layout_.height; ++y) {
            if (TIFFReadScanline(tiff_, row.get(), y, static_cast<std::uint16_t>(plane)) < 0) {
                refuse_malformed(source_);
            }
            make_rows(y + 1);
            put(row.get(), 0, layout_.width, y, plane);
        }
    }

    // The raster grows with what has been decoded: a header alone takes no memory.
    void make_rows(std::uint64_t count) {
        const std::size_t row = static_cast<std::size_t>(layout_.width) * layout_.channels();
        if (samples_.size() >= count * row) return;
        samples_.reserve(layout_.height * row);
        samples_.resize(count * row);
    }

    void read_tiles(int plane) {
        std::uint32_t tile_width = 0, tile_height = 0;
        TIFFGetField(tiff_, TIFFTAG_TILEWIDTH, &tile_width);
        TIFFGetField(tiff_, TIFFTAG_TILELENGTH, &tile_height);
        const std::uint64_t row_bytes = TIFFTileRowSize64(tiff_), bytes = TIFFTileSize64(tiff_);
        const std::uint64_t needed =
            (static_cast<std::uint64_t>(tile_width) * (layout_.planes ? 1 : layout_.samples) * layout_.bits +
             7) /
            8;
        if (tile_width == 0 || tile_height == 0 || row_bytes < needed || bytes / tile_height < row_bytes ||
            bytes > (1u << 30)) {
            refuse(source_.file.path, "malformed TIFF: impossible tile size; export it again");
        }
        // Not a vector: a tile far larger than the picture then costs address space only.
        const std::unique_ptr<std::uint8_t[]> tile(new std::uint8_t[bytes]);
        for (std::uint64_t top = 0; top < layout_.height; top += tile_height) {
            for (std::uint64_t left = 0; left < layout_.width; left += tile_width) {
                const auto x = static_cast<std::uint32_t>(left), y = static_cast<std::uint32_t>(top);
                if (TIFFReadTile(tiff_, tile.get(), x, y, 0, static_cast<std::uint16_t>(plane)) < 0) {
                    refuse_malformed(source_);
                }
                const std::uint32_t columns = std::min(tile_width, layout_.width - x);
                const std::uint32_t rows = std::min(tile_height, layout_.height - y);
                make_rows(top + rows);
                for (std::uint32_t row = 0; row < rows; ++row) {
                    put(tile.get() + row * row_bytes, x, columns, y + row, plane);
                }
            }
        }
    }

    // One run of pixels from a row of the file into the raster.
    void put(const std::uint8_t* row, std::uint32_t x, std::uint32_t count, std::uint32_t y, int plane) {
        const int channels = layout_.channels();
        const int stride = layout_.planes ? 1 : layout_.samples;
        const int from = layout_.planes ? plane : 0, to = layout_.planes ? plane + 1 : channels;
        Sample* out = samples_.data() + (static_cast<std::size_t>(y) * layout_.width + x) * channels;
        for (std::size_t i = 0; i < count; ++i) {
            for (int c = from; c < to; ++c) {
                Sample value = sample_at<Sample>(row, i * stride + (layout_.planes ? 0 : c), layout_.bits);
                if constexpr (!std::is_same_v<Sample, float>) {
                    if (layout_.photometric == PHOTOMETRIC_MINISWHITE) {
                        value = static_cast<Sample>(((1u << layout_.bits) - 1) - value);
                    }
                }
                out[i * channels + c] = value;
            }
        }
    }

    TIFF* tiff_;
    const Layout& layout_;
    TiffSource& source_;
    std::vector<Sample> samples_;
};

// libtiff's conversion clears memory for a whole strip or tile before it looks at the file. Where that is
// much, the first one is decoded alone into memory that nobody has touched.
void try_first_part(TIFF* tiff, const TiffSource& source) {
    constexpr tmsize_t much = 16 << 20, most = static_cast<tmsize_t>(1) << 33;
    const bool tiled = TIFFIsTiled(tiff);
    const tmsize_t bytes = tiled ? TIFFTileSize(tiff) : TIFFStripSize(tiff);
    if (bytes <= much) return;
    if (bytes > most) refuse(source.file.path, "malformed TIFF: impossible strip size; export it again");
    const std::unique_ptr<std::uint8_t[]> part(new std::uint8_t[static_cast<std::size_t>(bytes)]);
    if ((tiled ? TIFFReadEncodedTile(tiff, 0, part.get(), bytes)
               : TIFFReadEncodedStrip(tiff, 0, part.get(), bytes)) < 0)
        refuse_malformed(source);
}

Raster read_converted(TIFF* tiff, const Layout& layout, TiffSource& source) {
    char reason[1024] = "";
    if (!TIFFRGBAImageOK(tiff, reason)) {
        refuse(source.file.path,
               std::string("TIFF variant not supported (") + reason + "); save it as grey or RGB");
    }
    try_first_part(tiff, source);
    // Asking for the orientation that the file has makes libtiff leave the rows alone.
    std::uint16_t orientation = ORIENTATION_TOPLEFT;
    TIFFGetFieldDefaulted(tiff, TIFFTAG_ORIENTATION, &orientation);
    const std::size_t pixels = static_cast<std::size_t>(layout.width) * layout.height;
    // Not touched before it is decoded, so that a header alone takes no memory.
    const std::unique_ptr<std::uint32_t[]> packed(new std::uint32_t[pixels]);
    if (!TIFFReadRGBAImageOriented(tiff, layout.width, layout.height, packed.get(), orientation, 1)) {
        refuse_malformed(source);
    }
    std::vector<std::uint8_t> samples(pixels * 3);
    for (std::size_t i = 0; i < pixels; ++i) {
        samples[3 * i] = static_cast<std::uint8_t>(TIFFGetR(packed[i]));
        samples[3 * i + 1] = static_cast<std::uint8_t>(TIFFGetG(packed[i]));
        samples[3 * i + 2] = static_cast<std::uint8_t>(TIFFGetB(packed[i]));
    }
    return {
        static_cast<int>(layout.width), static_cast<int>(layout.height), 3, 255, kNoData, std::move(samples)};
}

}  // namespace

FileDescription describe_tiff(const SourceFile& file) {
    TiffSource source{file};
    const TiffHandle tiff = open(source);
    const Layout layout = read_layout(tiff.get(), source);
    const bool palette = layout.photometric == PHOTOMETRIC_PALETTE;
    return {"tiff",
            static_cast<int>(layout.width),
            static_cast<int>(layout.height),
            palette ? 3 : layout.samples,
            palette ? 8 : layout.bits,
            layout.format == SAMPLEFORMAT_IEEEFP};
}

Raster decode_tiff(const SourceFile& file) {
    TiffSource source{file};
    const TiffHandle tiff = open(source);
    const Layout layout = read_layout(tiff.get(), source);
    check_promise(layout, source);
    if (!stored_plainly(layout)) return read_converted(tiff.get(), layout, source);
    check_samples(layout, source);

    Raster raster;
    raster.width = static_cast<int>(layout.width);
    raster.height = static_cast<int>(layout.height);
    raster.channels = layout.channels();
    raster.nodata = nodata_of(tiff.get());
    raster.max_value = layout.bits <= 16 ? (1u << layout.bits) - 1 : 0;
    if (layout.format == SAMPLEFORMAT_IEEEFP) {
        raster.samples = PlainReader<float>(tiff.get(), layout, source).read();
    } else if (layout.bits == 16) {
        raster.samples = PlainReader<std::uint16_t>(tiff.get(), layout, source).read();
    } else {
        raster.samples = PlainReader<std::uint8_t>(tiff.get(), layout, source).read();
    }
    if (layout.alpha) split_alpha(raster);
    return raster;
}

}  // namespace hexrelief::codec
