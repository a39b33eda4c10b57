#include "exporters/images/jpeg_blocks.h"

#include <algorithm>
#include <cstring>
#include <utility>

#include "exporters/images/jpeg_encoder.h"
#include "pipeline/data/error.h"

namespace hexrelief::exporters {
namespace {

// The source's objects. Each is destroyed by the destructor, whether a step failed or not.
struct SourceFile {
    SourceFile() {
        for (jpeg_decompress_struct* object : {&pixels, &blocks}) object->err = catch_errors(errors);
    }
    SourceFile(const SourceFile&) = delete;
    SourceFile& operator=(const SourceFile&) = delete;
    ~SourceFile() {
        for (jpeg_decompress_struct* object : {&pixels, &blocks}) jpeg_destroy_decompress(object);
    }

    JpegErrors errors = {};
    jpeg_decompress_struct pixels = {}, blocks = {};
    std::vector<std::uint8_t> line;
    std::vector<std::vector<JBLOCKROW>> rows;  // of blocks, of each component
    bool keeps_blocks = false;
};

void open(jpeg_decompress_struct& object, const std::vector<std::uint8_t>& bytes) {
    jpeg_create_decompress(&object);
    jpeg_mem_src(&object, bytes.data(), static_cast<unsigned long>(bytes.size()));
    jpeg_read_header(&object, TRUE);
}

bool header_step(SourceFile& source, const std::vector<std::uint8_t>& bytes) {
    if (setjmp(source.errors.jump)) return false;
    open(source.pixels, bytes);
    open(source.blocks, bytes);
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
bool compare_step(SourceFile& source, const Image& picture, const PixelRect& part) {
    if (setjmp(source.errors.jump)) return false;
    jpeg_decompress_struct& pixels = source.pixels;
    pixels.out_color_space = picture.channels == 1 ? JCS_GRAYSCALE : JCS_RGB;
    jpeg_start_decompress(&pixels);
    const int rows = std::min(part.y + part.height, static_cast<int>(pixels.output_height));
    const std::size_t from = static_cast<std::size_t>(part.x) * picture.channels;
    const std::size_t count = static_cast<std::size_t>(part.width) * picture.channels;
    JSAMPROW line = source.line.data();
    bool is_same = true;
    for (int y = 0; y < rows && is_same; ++y) {
        jpeg_read_scanlines(&pixels, &line, 1);
        is_same = y < part.y || std::memcmp(line + from, picture.at(part.x, y), count) == 0;
    }
    jpeg_abort_decompress(&pixels);
    source.keeps_blocks = is_same && rows > part.y;
    return true;
}

bool blocks_step(SourceFile& source) {
    if (setjmp(source.errors.jump)) return false;
    jpeg_decompress_struct& file = source.blocks;
    jvirt_barray_ptr* arrays = jpeg_read_coefficients(&file);
    if (source.errors.manager.num_warnings > 0) return false;  // damaged data are grey
    for (int c = 0; c < file.num_components; ++c)
        for (JDIMENSION row = 0; row < source.rows[c].size(); ++row)
            source.rows[c][row] = file.mem->access_virt_barray(reinterpret_cast<j_common_ptr>(&file),
                                                               arrays[c], row, 1, FALSE)[0];
    return true;
}

bool read_blocks(SourceFile& source) {
    for (int c = 0; c < source.blocks.num_components; ++c)
        source.rows.emplace_back(source.blocks.comp_info[c].height_in_blocks);
    return blocks_step(source);
}

void use_tables(const jpeg_decompress_struct& source, jpeg_compress_struct& encoder) {
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
}

// Replaces a row of blocks of the part by the source's, as far as the source reaches.
void take_blocks(const SourceFile& source, const PixelRect& part, int component, JDIMENSION row,
                 JBLOCKROW blocks, JDIMENSION columns) {
    const jpeg_component_info& from = source.blocks.comp_info[component];
    const bool is_grey = source.blocks.num_components == 1;  // blocks of one size, whatever its factors are
    const auto block_at = [&](int px, int factor, int largest) {
        return static_cast<JDIMENSION>(is_grey ? px / DCTSIZE : px / (DCTSIZE * largest) * factor);
    };
    const JDIMENSION x = block_at(part.x, from.h_samp_factor, source.blocks.max_h_samp_factor),
                     y = block_at(part.y, from.v_samp_factor, source.blocks.max_v_samp_factor) + row;
    if (y < from.height_in_blocks)
        std::memcpy(blocks, source.rows[component][y] + x,
                    std::min(columns, from.width_in_blocks - x) * sizeof(JBLOCK));
}

// A file's blocks written again, in scans.
struct Rewriter {
    Rewriter() {
        from.err = catch_errors(errors);
        to.err = catch_errors(errors);
    }
    Rewriter(const Rewriter&) = delete;
    Rewriter& operator=(const Rewriter&) = delete;
    ~Rewriter() {
        jpeg_destroy_decompress(&from);
        jpeg_destroy_compress(&to);
    }

    JpegErrors errors = {};
    jpeg_decompress_struct from = {};
    jpeg_compress_struct to = {};
    JpegSink sink;
};

bool rewrite_step(Rewriter& rewriter, const std::vector<std::uint8_t>& bytes) {
    if (setjmp(rewriter.errors.jump)) return false;
    open(rewriter.from, bytes);
    jvirt_barray_ptr* blocks = jpeg_read_coefficients(&rewriter.from);
    jpeg_create_compress(&rewriter.to);
    rewriter.to.dest = &rewriter.sink.manager;
    jpeg_copy_critical_parameters(&rewriter.from, &rewriter.to);
    jpeg_simple_progression(&rewriter.to);
    jpeg_write_coefficients(&rewriter.to, blocks);
    jpeg_finish_compress(&rewriter.to);
    return true;
}

}  // namespace

JpegOfBlocks encode_jpeg_as(const std::vector<std::uint8_t>& bytes, const Image& picture,
                            const PixelRect& part, int threads) {
    SourceFile source;
    if (!header_step(source, bytes) || !is_usable(source.blocks, picture)) return {};
    const bool reaches = part.x + part.width <= static_cast<int>(source.blocks.image_width);
    if (reaches && part.x % kJpegBlock_px == 0 && part.y % kJpegBlock_px == 0) {
        source.line.resize(static_cast<std::size_t>(source.blocks.image_width) * picture.channels);
        if (!compare_step(source, picture, part)) return {};
    }
    if (source.keeps_blocks && !read_blocks(source)) return {};
    JpegSettings settings{[&](jpeg_compress_struct& jpeg) { use_tables(source.blocks, jpeg); }};
    if (source.keeps_blocks)
        settings.replace = [&](int component, JDIMENSION row, JBLOCKROW blocks, JDIMENSION columns) {
            take_blocks(source, part, component, row, blocks, columns);
        };
    std::vector<std::uint8_t> file;
    try {
        file = encode_baseline_jpeg(picture, part, settings, threads);
    } catch (const Error&) {  // tables or blocks that no file may have
        return {};
    }
    if (source.blocks.progressive_mode) {
        Rewriter rewriter;
        if (!rewrite_step(rewriter, file)) return {};
        file = std::move(rewriter.sink.bytes);
    }
    return {std::move(file), source.keeps_blocks};
}

}  // namespace hexrelief::exporters
