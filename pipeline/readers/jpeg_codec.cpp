// Reads JPEG by libjpeg. As for PNG, its errors leave by longjmp: every call that can fail runs in a step, a
// function whose frame holds nothing with a destructor, and memory is allocated between the steps.
#include <cstdio>
// libjpeg's headers need stdio first
#include <jpeglib.h>
// and its message codes come after
#include <jerror.h>

#include <algorithm>
#include <csetjmp>
#include <cstdlib>

#include "pipeline/readers/codecs.h"

namespace hexrelief::readers::codec {
namespace {

// A scan costs time for the whole picture; a small file can list thousands of empty ones.
constexpr int kMaxScans = 500;

struct JpegReader {
    explicit JpegReader(const SourceFile& file) : source(file) {}
    JpegReader(const JpegReader&) = delete;
    JpegReader& operator=(const JpegReader&) = delete;
    ~JpegReader() {
        std::free(profile);
        jpeg_destroy_decompress(&jpeg);
    }

    const SourceFile& source;
    jpeg_decompress_struct jpeg{};
    jpeg_error_mgr errors{};
    jpeg_progress_mgr progress{};
    std::jmp_buf escape{};
    char message[JMSG_LENGTH_MAX] = "";
    std::uint8_t* samples = nullptr;  // of the rows decoded so far, and of those up to end_row
    unsigned end_row = 0;
    JOCTET* profile = nullptr;
    unsigned profile_bytes = 0;
};

JpegReader& owner(j_common_ptr jpeg) {
    return *static_cast<JpegReader*>(jpeg->client_data);
}

void on_error(j_common_ptr jpeg) {
    jpeg->err->format_message(jpeg, owner(jpeg).message);
    std::longjmp(owner(jpeg).escape, 1);
}

// libjpeg replaces damaged data by grey with a warning, and a matcher would take that for the scene, so
// warnings are errors. Harmless oddities of writers are accepted.
void on_message(j_common_ptr jpeg, int level) {
    if (level >= 0) return;
    switch (jpeg->err->msg_code) {
        case JWRN_EXTRANEOUS_DATA:
        case JWRN_ADOBE_XFORM:
        case JWRN_JFIF_MAJOR:
        case JWRN_NOT_SEQUENTIAL:
        case JWRN_TOO_MUCH_DATA:
            return;
        default:
            on_error(jpeg);
    }
}

void on_progress(j_common_ptr jpeg) {
    if (owner(jpeg).jpeg.input_scan_number > kMaxScans) ERREXIT(jpeg, JERR_BAD_PROGRESSION);
}

void header_step(JpegReader& reader) {
    jpeg_create_decompress(&reader.jpeg);
    reader.jpeg.client_data = &reader;
    reader.jpeg.progress = &reader.progress;
    jpeg_mem_src(&reader.jpeg, reader.source.bytes.data(),
                 static_cast<unsigned long>(reader.source.bytes.size()));
    jpeg_save_markers(&reader.jpeg, JPEG_APP0 + 2, 0xffff);  // the colour profile's
    jpeg_read_header(&reader.jpeg, TRUE);
}

void start_step(JpegReader& reader) {
    if (!jpeg_read_icc_profile(&reader.jpeg, &reader.profile, &reader.profile_bytes))
        reader.profile = nullptr;
    jpeg_start_decompress(&reader.jpeg);
}

void rows_step(JpegReader& reader) {
    const std::size_t stride =
        static_cast<std::size_t>(reader.jpeg.output_width) * reader.jpeg.output_components;
    while (reader.jpeg.output_scanline < reader.end_row) {
        JSAMPROW row = reader.samples + stride * reader.jpeg.output_scanline;
        jpeg_read_scanlines(&reader.jpeg, &row, 1);
    }
}

void run(JpegReader& reader, void (*step)(JpegReader&)) {
    if (setjmp(reader.escape) == 0) {
        step(reader);
        return;
    }
    refuse(reader.source.path,
           std::string("malformed JPEG: ") + reader.message + "; copy or export it again");
}

void open(JpegReader& reader) {
    reader.jpeg.err = jpeg_std_error(&reader.errors);
    reader.jpeg.client_data = &reader;  // jpeg_create_decompress keeps both
    reader.errors.error_exit = on_error;
    reader.errors.emit_message = on_message;
    reader.errors.output_message = [](j_common_ptr) {};
    reader.progress.progress_monitor = on_progress;
    run(reader, header_step);
    check_size(reader.source, reader.jpeg.image_width, reader.jpeg.image_height);
}

// Converts in place, four bytes to three. Adobe's files, and so nearly all, hold the inks inverted.
void cmyk_to_rgb(std::vector<std::uint8_t>& samples, bool inverted) {
    const std::size_t pixels = samples.size() / 4;
    const auto light = [inverted](std::uint8_t ink) { return inverted ? ink : 255 - ink; };
    for (std::size_t i = 0; i < pixels; ++i) {
        const int black = light(samples[4 * i + 3]);
        for (std::size_t c = 0; c < 3; ++c)
            samples[3 * i + c] = static_cast<std::uint8_t>((light(samples[4 * i + c]) * black + 127) / 255);
    }
    samples.resize(pixels * 3);
}

}  // namespace

FileDescription describe_jpeg(const SourceFile& source) {
    JpegReader reader(source);
    open(reader);
    return {"jpeg", static_cast<int>(reader.jpeg.image_width), static_cast<int>(reader.jpeg.image_height),
            reader.jpeg.num_components, reader.jpeg.data_precision};
}

Raster decode_jpeg(const SourceFile& source) {
    JpegReader reader(source);
    open(reader);
    jpeg_decompress_struct& jpeg = reader.jpeg;
    const bool grey = jpeg.jpeg_color_space == JCS_GRAYSCALE;
    const bool inks = jpeg.jpeg_color_space == JCS_CMYK || jpeg.jpeg_color_space == JCS_YCCK;
    jpeg.out_color_space = grey ? JCS_GRAYSCALE : inks ? JCS_CMYK : JCS_RGB;
    const int stored = grey ? 1 : inks ? 4 : 3;
    const unsigned long long pixels = static_cast<unsigned long long>(jpeg.image_width) * jpeg.image_height;
    // Huffman codes spend at least a bit on a block of 64 pixels; arithmetic codes may spend less.
    check_length(source, pixels, jpeg.arith_code ? 4096 : 512);

    // Memory is touched as rows are decoded: truncated data end before the rows that the header promises.
    constexpr unsigned band_rows = 64;
    std::vector<std::uint8_t> samples;
    samples.reserve(pixels * stored);
    run(reader, start_step);
    while (reader.end_row < jpeg.image_height) {
        reader.end_row = std::min(reader.end_row + band_rows, jpeg.image_height);
        samples.resize(static_cast<std::size_t>(reader.end_row) * jpeg.image_width * stored);
        reader.samples = samples.data();
        run(reader, rows_step);
    }
    run(reader, [](JpegReader& read) { jpeg_finish_decompress(&read.jpeg); });
    if (inks) cmyk_to_rgb(samples, jpeg.saw_Adobe_marker);
    const int width = static_cast<int>(jpeg.image_width), height = static_cast<int>(jpeg.image_height);
    Raster raster{width, height, grey ? 1 : 3, 255, kNoData, std::move(samples)};
    if (reader.profile != nullptr)
        raster.profile.assign(reader.profile, reader.profile + reader.profile_bytes);
    return raster;
}

}  // namespace hexrelief::readers::codec
