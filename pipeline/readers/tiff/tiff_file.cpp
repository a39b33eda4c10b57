// Samples are read as stored, because the samples of a map mean the numbers themselves, and alpha must
// not darken a colour.
#include "pipeline/readers/tiff/tiff_file.h"

#include <algorithm>
#include <cstdarg>
#include <cstdio>
#include <cstring>
#include <type_traits>

#include "pipeline/readers/parse_text.h"

namespace hexrelief::readers::codec {
namespace {

TiffSource& source_of(thandle_t handle) {
    return *static_cast<TiffSource*>(handle);
}

tmsize_t on_read(thandle_t handle, void* to, tmsize_t count) {
    TiffSource& source = source_of(handle);
    const std::uint64_t size = source.bytes;
    const std::uint64_t left = source.position < size ? size - source.position : 0;
    const std::uint64_t got =
        std::min<std::uint64_t>(left, static_cast<std::uint64_t>(std::max<tmsize_t>(count, 0)));
    if (got > 0 && !source.copy(source.position, to, got)) return 0;
    source.position += got;
    return static_cast<tmsize_t>(got);
}

toff_t on_seek(thandle_t handle, toff_t offset, int whence) {
    TiffSource& source = source_of(handle);
    if (whence == SEEK_CUR) offset += source.position;
    if (whence == SEEK_END) offset += source.bytes;
    return source.position = offset;
}

// Keeps the first message. Nonzero = handled, so that libtiff's global handler prints nothing.
int on_error(TIFF*, void* user, const char*, const char* format, va_list arguments) {
    auto& source = *static_cast<TiffSource*>(user);
    if (source.message[0] == '\0') std::vsnprintf(source.message, sizeof source.message, format, arguments);
    return 1;
}

struct OptionsFreer {
    void operator()(TIFFOpenOptions* options) const { TIFFOpenOptionsFree(options); }
};

template <typename Stored>
Stored stored_at(const std::uint8_t* row, std::size_t index) {
    Stored value;
    std::memcpy(&value, row + index * sizeof(Stored), sizeof(Stored));
    return value;
}

float number_at(const std::uint8_t* row, std::size_t index, const TiffLayout& layout) {
    if (layout.format == SAMPLEFORMAT_IEEEFP) {
        if (layout.bits == 16) return float_of_half(stored_at<std::uint16_t>(row, index));
        return layout.bits == 64 ? static_cast<float>(stored_at<double>(row, index))
                                 : stored_at<float>(row, index);
    }
    if (layout.format != SAMPLEFORMAT_INT) return static_cast<float>(stored_at<std::uint32_t>(row, index));
    if (layout.bits == 8) return stored_at<std::int8_t>(row, index);
    if (layout.bits == 16) return stored_at<std::int16_t>(row, index);
    return static_cast<float>(stored_at<std::int32_t>(row, index));
}

// Returns a sample; libtiff has already converted the bytes to the machine's order.
template <typename Sample>
Sample sample_at(const std::uint8_t* row, std::size_t index, const TiffLayout& layout) {
    if constexpr (std::is_same_v<Sample, float>) {
        return number_at(row, index, layout);
    } else {
        const unsigned bits = layout.bits;
        if (bits == 8 * sizeof(Sample)) return stored_at<Sample>(row, index);
        const std::size_t bit = index * bits;
        return static_cast<Sample>(row[bit / 8] >> (8 - bits - bit % 8) & ((1u << bits) - 1));
    }
}

template <typename Sample>
class PlainReader {
  public:
    PlainReader(TIFF* tiff, const TiffLayout& layout, TiffSource& source, const PixelWindow& window)
        : tiff_(tiff), layout_(layout), source_(source), window_(window) {}

    std::vector<Sample> read() {
        const int planes = layout_.planes ? layout_.channels() : 1;
        for (int plane = 0; plane < planes; ++plane)
            if (TIFFIsTiled(tiff_))
                read_tiles(plane);
            else
                read_rows(plane);
        return std::move(samples_);
    }

  private:
    std::uint32_t right() const { return window_.x + window_.width; }
    std::uint32_t bottom() const { return window_.y + window_.height; }

    void read_rows(int plane) {
        const auto bytes = static_cast<std::size_t>(TIFFScanlineSize64(tiff_));
        if (bytes < layout_.row_bytes()) refuse_malformed(source_);
        if (bytes > (std::size_t{1} << 33)) refuse(source_.path, "its rows are too long; crop it first");
        const std::unique_ptr<std::uint8_t[]> row(new std::uint8_t[bytes]);  // not touched before it is read
        // Compressed strips are decoded from their first row on.
        std::uint32_t rows_per_strip = 0;
        TIFFGetFieldDefaulted(tiff_, TIFFTAG_ROWSPERSTRIP, &rows_per_strip);
        const std::uint32_t first = rows_per_strip == 0 ? 0 : window_.y - window_.y % rows_per_strip;
        for (std::uint32_t y = first; y < bottom(); ++y) {
            if (TIFFReadScanline(tiff_, row.get(), y, static_cast<std::uint16_t>(plane)) < 0)
                refuse_malformed(source_);
            if (y < window_.y) continue;
            make_rows(y + 1);
            put(row.get(), 0, layout_.width, y, plane);
        }
    }

    // Enlarges the raster to the rows decoded so far, down to `end`: a header without
    // samples costs no memory.
    void make_rows(std::uint64_t end) {
        const std::size_t row = static_cast<std::size_t>(window_.width) * layout_.channels();
        const std::uint64_t count = std::min<std::uint64_t>(end, bottom()) - window_.y;
        if (samples_.size() >= count * row) return;
        samples_.reserve(window_.height * row);
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
            bytes > (1u << 30))
            refuse(source_.path, "malformed TIFF: impossible tile size; export it again");
        // Not a vector: a tile far larger than the picture then costs address space only.
        const std::unique_ptr<std::uint8_t[]> tile(new std::uint8_t[bytes]);
        for (std::uint64_t top = window_.y - window_.y % tile_height; top < bottom(); top += tile_height)
            for (std::uint64_t left = window_.x - window_.x % tile_width; left < right();
                 left += tile_width) {
                const auto x = static_cast<std::uint32_t>(left), y = static_cast<std::uint32_t>(top);
                if (TIFFReadTile(tiff_, tile.get(), x, y, 0, static_cast<std::uint16_t>(plane)) < 0)
                    refuse_malformed(source_);
                const std::uint32_t columns = std::min(tile_width, layout_.width - x);
                const std::uint32_t rows = std::min(tile_height, layout_.height - y);
                make_rows(top + rows);
                for (std::uint32_t row = 0; row < rows; ++row)
                    put(tile.get() + row * row_bytes, x, columns, y + row, plane);
            }
    }

    bool is_stored_as_wanted() const {
        return layout_.bits == 8 * sizeof(Sample) && !layout_.planes &&
               layout_.samples == layout_.channels() &&
               (std::is_same_v<Sample, float> ? layout_.format == SAMPLEFORMAT_IEEEFP
                                              : layout_.photometric != PHOTOMETRIC_MINISWHITE);
    }

    // Stores the window's part of a run of `count` pixels of the file that begins at x, y.
    void put(const std::uint8_t* row, std::uint32_t x, std::uint32_t count, std::uint32_t y, int plane) {
        if (y < window_.y || y >= bottom()) return;
        const std::uint32_t first = std::max(x, window_.x), last = std::min(x + count, right());
        const int channels = layout_.channels();
        const int stride = layout_.planes ? 1 : layout_.samples;
        const int from = layout_.planes ? plane : 0, to = layout_.planes ? plane + 1 : channels;
        Sample* out = samples_.data() + static_cast<std::size_t>(y - window_.y) * window_.width * channels;
        if (is_stored_as_wanted() && first < last) {
            std::memcpy(out + std::size_t{first - window_.x} * channels,
                        row + std::size_t{first - x} * channels * sizeof(Sample),
                        std::size_t{last - first} * channels * sizeof(Sample));
            return;
        }
        for (std::size_t i = first; i < last; ++i)
            for (int c = from; c < to; ++c) {
                Sample value = sample_at<Sample>(row, (i - x) * stride + (layout_.planes ? 0 : c), layout_);
                if constexpr (!std::is_same_v<Sample, float>) {
                    if (layout_.photometric == PHOTOMETRIC_MINISWHITE)
                        value = static_cast<Sample>(((1u << layout_.bits) - 1) - value);
                }
                out[(i - window_.x) * channels + c] = value;
            }
    }

    TIFF* tiff_;
    const TiffLayout& layout_;
    TiffSource& source_;
    PixelWindow window_;
    std::vector<Sample> samples_;
};

}  // namespace

void refuse_malformed(const TiffSource& source) {
    const std::string reason =
        source.message[0] ? printable(source.message, sizeof source.message) : "damaged or truncated";
    refuse(source.path, "malformed TIFF: " + reason + "; copy or export it again");
}

TiffHandle open_tiff(TiffSource& source) {
    const std::unique_ptr<TIFFOpenOptions, OptionsFreer> options(TIFFOpenOptionsAlloc());
    if (!options) refuse(source.path, "libtiff could not be started (out of memory)");
    // A damaged tag can ask for any amount; the most that can be right is a strip of the largest picture.
    TIFFOpenOptionsSetMaxSingleMemAlloc(options.get(), static_cast<tmsize_t>(1) << 33);
    TIFFOpenOptionsSetErrorHandlerExtR(options.get(), on_error, &source);
    TIFFOpenOptionsSetWarningHandlerExtR(
        options.get(), [](TIFF*, void*, const char*, const char*, va_list) { return 1; }, nullptr);
    const auto on_write = [](thandle_t, void*, tmsize_t) -> tmsize_t { return 0; };
    const auto on_close = [](thandle_t) { return 0; };
    const auto on_size = [](thandle_t handle) -> toff_t { return source_of(handle).bytes; };
    // m: no memory mapping, the bytes are copied strip by strip
    TiffHandle tiff(TIFFClientOpenExt("file", "rm", &source, on_read, on_write, on_seek, on_close, on_size,
                                      nullptr, nullptr, options.get()));
    if (!tiff) refuse_malformed(source);
    return tiff;
}

TiffLayout read_layout(TIFF* tiff, const TiffSource& source) {
    TiffLayout layout;
    TIFFGetField(tiff, TIFFTAG_IMAGEWIDTH, &layout.width);
    TIFFGetField(tiff, TIFFTAG_IMAGELENGTH, &layout.height);
    TIFFGetFieldDefaulted(tiff, TIFFTAG_SAMPLESPERPIXEL, &layout.samples);
    TIFFGetFieldDefaulted(tiff, TIFFTAG_BITSPERSAMPLE, &layout.bits);
    TIFFGetFieldDefaulted(tiff, TIFFTAG_SAMPLEFORMAT, &layout.format);
    TIFFGetFieldDefaulted(tiff, TIFFTAG_COMPRESSION, &layout.compression);
    std::uint16_t planar = PLANARCONFIG_CONTIG;
    TIFFGetFieldDefaulted(tiff, TIFFTAG_PLANARCONFIG, &planar);
    layout.planes = planar == PLANARCONFIG_SEPARATE && layout.samples > 1;
    if (!TIFFGetField(tiff, TIFFTAG_PHOTOMETRIC, &layout.photometric))  // some writers leave it out
        layout.photometric = layout.samples >= 3 ? PHOTOMETRIC_RGB : PHOTOMETRIC_MINISBLACK;
    std::uint16_t extras = 0;
    const std::uint16_t* kinds = nullptr;
    TIFFGetFieldDefaulted(tiff, TIFFTAG_EXTRASAMPLES, &extras, &kinds);
    layout.alpha = extras > 0 && kinds[0] != EXTRASAMPLE_UNSPECIFIED && layout.samples > layout.channels() &&
                   (layout.bits == 8 || layout.bits == 16) && layout.format == SAMPLEFORMAT_UINT &&
                   layout.photometric != PHOTOMETRIC_MINISWHITE;
    if (layout.samples < 1 || layout.samples > 16)
        refuse(source.path,
               "it has " + std::to_string(layout.samples) + " samples a pixel; save it as grey or RGB");
    return layout;
}

bool stored_plainly(const TiffLayout& layout) {
    return layout.photometric == PHOTOMETRIC_MINISBLACK || layout.photometric == PHOTOMETRIC_MINISWHITE ||
           (layout.photometric == PHOTOMETRIC_RGB && layout.samples >= 3);
}

bool are_wide_integers(const TiffLayout& layout) {
    return layout.format == SAMPLEFORMAT_INT ||
           (layout.bits == 32 && layout.format != SAMPLEFORMAT_IEEEFP &&
            layout.format != SAMPLEFORMAT_COMPLEXINT && layout.format != SAMPLEFORMAT_COMPLEXIEEEFP);
}

void check_samples(const TiffLayout& layout, const TiffSource& source) {
    const bool whole = layout.format == SAMPLEFORMAT_UINT || layout.format == SAMPLEFORMAT_VOID;
    const bool real = layout.format == SAMPLEFORMAT_IEEEFP;
    if (whole &&
        (layout.bits == 1 || layout.bits == 2 || layout.bits == 4 || layout.bits == 8 || layout.bits == 16))
        return;
    if (real && (layout.bits == 16 || layout.bits == 32 || layout.bits == 64)) return;
    if (are_wide_integers(layout) &&
        (layout.bits == 32 || (!whole && (layout.bits == 8 || layout.bits == 16))))
        return;
    refuse(source.path, "its TIFF samples are " + std::to_string(layout.bits) + "-bit " +
                            (whole                               ? "unsigned"
                             : real                              ? "float"
                             : layout.format == SAMPLEFORMAT_INT ? "signed"
                                                                 : "complex") +
                            "; save it as 8 or 16-bit integers or 32-bit float");
}

double nodata_of(TIFF* tiff) {
    constexpr std::uint32_t tag = 42113;  // GDAL's, a number as text
    std::uint32_t count = 0;
    void* text = nullptr;
    if (!TIFFGetField(tiff, tag, &count, &text) || text == nullptr) return kNoData;
    const TIFFField* const field = TIFFFieldWithTag(tiff, tag);
    if (field == nullptr || TIFFFieldDataType(field) != TIFF_ASCII) return kNoData;
    std::string_view number(static_cast<const char*>(text), count);
    return parse_number(number.substr(0, number.find('\0'))).value_or(kNoData);
}

std::vector<std::uint8_t> profile_of(TIFF* tiff) {
    std::uint32_t count = 0;
    void* bytes = nullptr;
    if (!TIFFGetField(tiff, TIFFTAG_ICCPROFILE, &count, &bytes) || bytes == nullptr) return {};
    const auto* const first = static_cast<const std::uint8_t*>(bytes);
    return {first, first + count};
}

Raster read_plainly(TIFF* tiff, const TiffLayout& layout, TiffSource& source, const PixelWindow& window) {
    check_samples(layout, source);
    Raster raster{.width = static_cast<int>(window.width),
                  .height = static_cast<int>(window.height),
                  .channels = layout.channels(),
                  .max_value = layout.bits <= 16 ? (1u << layout.bits) - 1 : 0,
                  .nodata = nodata_of(tiff),
                  .profile = profile_of(tiff)};
    if (layout.format == SAMPLEFORMAT_IEEEFP) {
        raster.samples = PlainReader<float>(tiff, layout, source, window).read();
    } else if (are_wide_integers(layout)) {
        hold_integers(raster, PlainReader<float>(tiff, layout, source, window).read(), layout.bits,
                      layout.format == SAMPLEFORMAT_INT);
    } else if (layout.bits == 16) {
        raster.samples = PlainReader<std::uint16_t>(tiff, layout, source, window).read();
    } else {
        raster.samples = PlainReader<std::uint8_t>(tiff, layout, source, window).read();
    }
    return raster;
}
}  // namespace hexrelief::readers::codec
