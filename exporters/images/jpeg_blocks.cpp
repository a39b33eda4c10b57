#include "exporters/images/jpeg_blocks.h"

#include <algorithm>
#include <cstring>

#include "exporters/images/jpeg_memory.h"

namespace hexrelief::exporters {
namespace {

// The objects of libjpeg for one picture. Each is destroyed by the destructor, whether a step failed or not.
struct Transcoder {
    Transcoder() {
        for (jpeg_decompress_struct* object : {&pixels, &source, &own}) object->err = catch_errors(errors);
        for (jpeg_compress_struct* object : {&encoder, &writer}) object->err = catch_errors(errors);
    }
    Transcoder(const Transcoder&) = delete;
    Transcoder& operator=(const Transcoder&) = delete;
    ~Transcoder() {
        for (jpeg_decompress_struct* object : {&pixels, &source, &own}) jpeg_destroy_decompress(object);
        for (jpeg_compress_struct* object : {&encoder, &writer}) jpeg_destroy_compress(object);
    }

    JpegErrors errors = {};
    jpeg_decompress_struct pixels = {};  // the source's pixels
    jpeg_decompress_struct source = {};  // its coefficients
    jpeg_compress_struct encoder = {};   // the part, encoded as the source is
    jpeg_decompress_struct own = {};     // its coefficients, of which some become the source's
    jpeg_compress_struct writer = {};
    jvirt_barray_ptr* coefficients = nullptr;  // the source's
    std::vector<std::uint8_t> row;
    JpegSink encoded, written;
    bool keeps_blocks = false;
};

void open(jpeg_decompress_struct& object, const std::vector<std::uint8_t>& bytes) {
    jpeg_create_decompress(&object);
    jpeg_mem_src(&object, bytes.data(), static_cast<unsigned long>(bytes.size()));
    jpeg_read_header(&object, TRUE);
}

bool header_step(Transcoder& coder, const std::vector<std::uint8_t>& bytes) {
    if (setjmp(coder.errors.jump)) return false;
    open(coder.pixels, bytes);
    open(coder.source, bytes);
    return true;
}

bool is_usable(const jpeg_decompress_struct& source, const Image& picture) {
    const bool grey = source.jpeg_color_space == JCS_GRAYSCALE;
    if (source.data_precision != 8 || (!grey && source.jpeg_color_space != JCS_YCbCr)) return false;
    if (source.num_components != picture.channels) return false;
    if (grey) return true;  // its blocks have one size, whatever its factors are
    for (int c = 0; c < source.num_components; ++c) {
        const jpeg_component_info& info = source.comp_info[c];
        const int most = c == 0 ? 2 : 1;
        if (info.h_samp_factor > most || info.v_samp_factor > most) return false;
    }
    return true;
}

// Sets keeps_blocks if the picture is the source's where the source reaches.
bool compare_step(Transcoder& coder, const Image& picture, const PixelRect& part) {
    if (setjmp(coder.errors.jump)) return false;
    jpeg_decompress_struct& source = coder.pixels;
    source.out_color_space = picture.channels == 1 ? JCS_GRAYSCALE : JCS_RGB;
    jpeg_start_decompress(&source);
    const int rows = std::min(part.y + part.height, static_cast<int>(source.output_height));
    const std::size_t from = static_cast<std::size_t>(part.x) * picture.channels;
    const std::size_t count = static_cast<std::size_t>(part.width) * picture.channels;
    JSAMPROW row = coder.row.data();
    bool is_same = true;
    for (int y = 0; y < rows && is_same; ++y) {
        jpeg_read_scanlines(&source, &row, 1);
        is_same = y < part.y || std::memcmp(row + from, picture.at(part.x, y), count) == 0;
    }
    jpeg_abort_decompress(&source);
    coder.keeps_blocks = is_same && rows > part.y;
    return true;
}

bool coefficients_step(Transcoder& coder) {
    if (setjmp(coder.errors.jump)) return false;
    coder.coefficients = jpeg_read_coefficients(&coder.source);
    return coder.errors.manager.num_warnings == 0;  // damaged data are grey
}

// Chooses the codes of the file that is returned.
void finish_as(jpeg_compress_struct& writer, const jpeg_decompress_struct& source) {
    writer.optimize_coding = TRUE;
    if (source.progressive_mode) jpeg_simple_progression(&writer);
}

bool encode_step(Transcoder& coder, const Image& picture, const PixelRect& part) {
    if (setjmp(coder.errors.jump)) return false;
    jpeg_compress_struct& encoder = coder.encoder;
    const jpeg_decompress_struct& source = coder.source;
    jpeg_create_compress(&encoder);
    encoder.dest = &coder.encoded.manager;
    encoder.image_width = static_cast<JDIMENSION>(part.width);
    encoder.image_height = static_cast<JDIMENSION>(part.height);
    encoder.input_components = picture.channels;
    encoder.in_color_space = picture.channels == 1 ? JCS_GRAYSCALE : JCS_RGB;
    jpeg_set_defaults(&encoder);
    for (int i = 0; i < NUM_QUANT_TBLS; ++i) {
        if (!source.quant_tbl_ptrs[i]) continue;
        if (!encoder.quant_tbl_ptrs[i])
            encoder.quant_tbl_ptrs[i] = jpeg_alloc_quant_table(reinterpret_cast<j_common_ptr>(&encoder));
        std::copy_n(source.quant_tbl_ptrs[i]->quantval, DCTSIZE2, encoder.quant_tbl_ptrs[i]->quantval);
    }
    for (int c = 0; c < encoder.num_components; ++c) {
        encoder.comp_info[c].quant_tbl_no = source.comp_info[c].quant_tbl_no;
        encoder.comp_info[c].h_samp_factor = source.comp_info[c].h_samp_factor;
        encoder.comp_info[c].v_samp_factor = source.comp_info[c].v_samp_factor;
    }
    if (!coder.keeps_blocks) finish_as(encoder, source);
    jpeg_start_compress(&encoder, TRUE);
    while (encoder.next_scanline < encoder.image_height) {
        const int y = part.y + static_cast<int>(encoder.next_scanline);
        JSAMPROW row = const_cast<JSAMPROW>(picture.at(part.x, y));
        jpeg_write_scanlines(&encoder, &row, 1);
    }
    jpeg_finish_compress(&encoder);
    return true;
}

// Replaces the blocks of one colour component by the source's, as far as the source reaches.
void take_blocks(Transcoder& coder, jvirt_barray_ptr* own, int component, const PixelRect& part) {
    const jpeg_component_info& to = coder.own.comp_info[component];
    const jpeg_component_info& from = coder.source.comp_info[component];
    const bool is_grey = coder.own.num_components == 1;
    const int across = DCTSIZE * (is_grey ? 1 : coder.source.max_h_samp_factor);
    const int down = DCTSIZE * (is_grey ? 1 : coder.source.max_v_samp_factor);
    const JDIMENSION x = static_cast<JDIMENSION>(part.x / across * (is_grey ? 1 : from.h_samp_factor));
    const JDIMENSION y = static_cast<JDIMENSION>(part.y / down * (is_grey ? 1 : from.v_samp_factor));
    const JDIMENSION columns = std::min(to.width_in_blocks, from.width_in_blocks - x);
    const JDIMENSION rows = std::min(to.height_in_blocks, from.height_in_blocks - y);
    const auto access = [](jpeg_decompress_struct& object, jvirt_barray_ptr blocks, JDIMENSION row,
                           boolean writable) {
        return object.mem->access_virt_barray(reinterpret_cast<j_common_ptr>(&object), blocks, row, 1,
                                              writable)[0];
    };
    for (JDIMENSION row = 0; row < rows; ++row)
        std::memcpy(access(coder.own, own[component], row, TRUE),
                    access(coder.source, coder.coefficients[component], y + row, FALSE) + x,
                    columns * sizeof(JBLOCK));
}

bool write_step(Transcoder& coder, const PixelRect& part) {
    if (setjmp(coder.errors.jump)) return false;
    open(coder.own, coder.encoded.bytes);
    jvirt_barray_ptr* own = jpeg_read_coefficients(&coder.own);
    for (int c = 0; c < coder.own.num_components; ++c) take_blocks(coder, own, c, part);
    jpeg_create_compress(&coder.writer);
    coder.writer.dest = &coder.written.manager;
    jpeg_copy_critical_parameters(&coder.own, &coder.writer);
    finish_as(coder.writer, coder.source);
    jpeg_write_coefficients(&coder.writer, own);
    jpeg_finish_compress(&coder.writer);
    return true;
}

}  // namespace

JpegOfBlocks encode_jpeg_as(const std::vector<std::uint8_t>& source, const Image& picture,
                            const PixelRect& part) {
    Transcoder coder;
    if (!header_step(coder, source) || !is_usable(coder.source, picture)) return {};
    const bool reaches = part.x + part.width <= static_cast<int>(coder.source.image_width);
    if (reaches && part.x % kJpegBlock_px == 0 && part.y % kJpegBlock_px == 0) {
        coder.row.resize(static_cast<std::size_t>(coder.source.image_width) * picture.channels);
        if (!compare_step(coder, picture, part)) return {};
    }
    if (coder.keeps_blocks && !coefficients_step(coder)) return {};
    if (!encode_step(coder, picture, part)) return {};
    if (!coder.keeps_blocks) return {std::move(coder.encoded.bytes)};
    if (!write_step(coder, part)) return {};
    return {std::move(coder.written.bytes), true};
}

}  // namespace hexrelief::exporters
