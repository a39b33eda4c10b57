// Reads PNG by libpng. Its errors leave by longjmp, so every call that can fail runs in a step: a function
// whose frame holds nothing with a destructor. Memory is allocated between the steps.
#include <png.h>

#include <algorithm>
#include <bit>
#include <csetjmp>
#include <cstring>

#include "pipeline/readers/codecs.h"

namespace hexrelief::readers::codec {
namespace {

struct PngReader {
    explicit PngReader(const SourceFile& file) : source(file) {}
    PngReader(const PngReader&) = delete;
    PngReader& operator=(const PngReader&) = delete;
    ~PngReader() {
        if (png) png_destroy_read_struct(&png, info ? &info : nullptr, nullptr);
    }

    const SourceFile& source;
    std::size_t position = 0;
    char message[128] = "";
    png_structp png = nullptr;
    png_infop info = nullptr;
    png_bytepp rows = nullptr;  // all, if interlaced; else those of a band
    unsigned row_count = 0;
    bool is_interlaced = false;
};

void on_error(png_structp png, png_const_charp message) {
    auto* reader = static_cast<PngReader*>(png_get_error_ptr(png));
    std::strncpy(reader->message, message, sizeof reader->message - 1);
    png_longjmp(png, 1);
}

void on_warning(png_structp, png_const_charp) {}

void on_read(png_structp png, png_bytep to, size_t count) {
    auto* reader = static_cast<PngReader*>(png_get_io_ptr(png));
    if (count > reader->source.bytes.size() - reader->position) png_error(png, "truncated");
    std::memcpy(to, reader->source.bytes.data() + reader->position, count);
    reader->position += count;
}

void header_step(PngReader& reader) {
    png_set_read_fn(reader.png, &reader, on_read);
    png_set_user_limits(reader.png, 0x7fffffff, 0x7fffffff);  // check_size has the clearer message
    png_read_info(reader.png, reader.info);
}

// True if there is an alpha channel, or a palette with transparent colours. A single transparent colour of a
// picture without a palette is ignored.
bool has_alpha(const PngReader& reader) {
    const int kind = png_get_color_type(reader.png, reader.info);
    return (kind & PNG_COLOR_MASK_ALPHA) != 0 ||
           (kind == PNG_COLOR_TYPE_PALETTE && png_get_valid(reader.png, reader.info, PNG_INFO_tRNS) != 0);
}

void transform_step(PngReader& reader) {
    const int kind = png_get_color_type(reader.png, reader.info);
    if (kind == PNG_COLOR_TYPE_PALETTE) png_set_palette_to_rgb(reader.png);
    if (!has_alpha(reader)) png_set_strip_alpha(reader.png);
    png_set_packing(reader.png);  // 1-2-4-bit grey: one byte each, not stretched
    if (std::endian::native == std::endian::little) png_set_swap(reader.png);
    reader.is_interlaced = png_set_interlace_handling(reader.png) > 1;
    png_read_update_info(reader.png, reader.info);
}

std::vector<std::uint8_t> profile_of(const PngReader& reader) {
    png_charp name = nullptr;
    png_bytep bytes = nullptr;
    png_uint_32 count = 0;
    int compression = 0;
    if (png_get_iCCP(reader.png, reader.info, &name, &compression, &bytes, &count) == 0) return {};
    return {bytes, bytes + count};
}

void rows_step(PngReader& reader) {
    if (reader.is_interlaced)
        png_read_image(reader.png, reader.rows);
    else
        png_read_rows(reader.png, reader.rows, nullptr, reader.row_count);
}

void run(PngReader& reader, void (*step)(PngReader&)) {
    if (setjmp(png_jmpbuf(reader.png)) == 0) {
        step(reader);
        return;
    }
    refuse(reader.source.path, std::string("malformed PNG: ") + reader.message + "; copy or export it again");
}

void open(PngReader& reader) {
    reader.png = png_create_read_struct(PNG_LIBPNG_VER_STRING, &reader, on_error, on_warning);
    if (reader.png) reader.info = png_create_info_struct(reader.png);
    if (!reader.info)
        refuse(reader.source.path, "libpng could not be started (out of memory or another version)");
    run(reader, header_step);
    check_size(reader.source, png_get_image_width(reader.png, reader.info),
               png_get_image_height(reader.png, reader.info));
}

template <typename Sample>
std::vector<Sample> read_rows(PngReader& reader, std::size_t row_samples, std::size_t height) {
    if (png_get_rowbytes(reader.png, reader.info) != row_samples * sizeof(Sample))
        refuse(reader.source.path, "its PNG colour type is not supported; save it as plain grey or RGB");
    // Memory is touched as rows are decoded: truncated data end before the rows that the header promises.
    const std::size_t band_rows = reader.is_interlaced ? height : 64;
    std::vector<Sample> samples;
    samples.reserve(row_samples * height);
    std::vector<png_bytep> rows;
    for (std::size_t y = 0; y < height; y += rows.size()) {
        rows.resize(std::min(band_rows, height - y));
        samples.resize(row_samples * (y + rows.size()));
        for (std::size_t i = 0; i < rows.size(); ++i)
            rows[i] = reinterpret_cast<png_bytep>(samples.data() + (y + i) * row_samples);
        reader.rows = rows.data();
        reader.row_count = static_cast<unsigned>(rows.size());
        run(reader, rows_step);
    }
    run(reader, [](PngReader& read) { png_read_end(read.png, nullptr); });
    return samples;
}

}  // namespace

FileDescription describe_png(const SourceFile& source) {
    PngReader reader(source);
    open(reader);
    const bool palette = png_get_color_type(reader.png, reader.info) == PNG_COLOR_TYPE_PALETTE;
    return {"png", static_cast<int>(png_get_image_width(reader.png, reader.info)),
            static_cast<int>(png_get_image_height(reader.png, reader.info)),
            palette ? 3 : png_get_channels(reader.png, reader.info),
            palette ? 8 : png_get_bit_depth(reader.png, reader.info)};
}

Raster decode_png(const SourceFile& source) {
    PngReader reader(source);
    open(reader);
    Raster raster{.width = static_cast<int>(png_get_image_width(reader.png, reader.info)),
                  .height = static_cast<int>(png_get_image_height(reader.png, reader.info))};
    const int kind = png_get_color_type(reader.png, reader.info);
    const int bits = kind == PNG_COLOR_TYPE_PALETTE ? 8 : png_get_bit_depth(reader.png, reader.info);
    const bool with_alpha = has_alpha(reader);
    raster.channels = (kind & PNG_COLOR_MASK_COLOR ? 3 : 1) + with_alpha;
    raster.max_value = (1u << bits) - 1;
    // Deflate compresses at best 1032 bytes into one.
    check_length(source,
                 png_get_rowbytes(reader.png, reader.info) * static_cast<unsigned long long>(raster.height),
                 1032);
    raster.profile = profile_of(reader);
    run(reader, transform_step);
    const std::size_t row_samples = static_cast<std::size_t>(raster.width) * raster.channels;
    if (bits == 16)
        raster.samples = read_rows<std::uint16_t>(reader, row_samples, raster.height);
    else
        raster.samples = read_rows<std::uint8_t>(reader, row_samples, raster.height);
    if (with_alpha) split_alpha(raster);
    return raster;
}

}  // namespace hexrelief::readers::codec
