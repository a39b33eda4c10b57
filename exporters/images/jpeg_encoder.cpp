#include "exporters/images/jpeg_encoder.h"

// After jpeglib.h.
#include <jerror.h>

#include <algorithm>
#include <array>
#include <new>
#include <string>

#include "exporters/images/jpeg_entropy.h"
#include "pipeline/base/thread_pool.h"
#include "pipeline/data/error.h"

namespace hexrelief::exporters {
namespace {

constexpr int kStripRows = 64;  // px; a multiple of the highest unit of several components' blocks
constexpr int kMostComponents = 3;

// libjpeg's encoder, which keeps the blocks of a picture until it is told to write them.
struct Encoder {
    Encoder() {
        jpeg.err = catch_errors(errors);
        jpeg.client_data = this;
    }
    Encoder(const Encoder&) = delete;
    Encoder& operator=(const Encoder&) = delete;
    ~Encoder() { jpeg_destroy_compress(&jpeg); }

    [[noreturn]] void fail() const {
        if (errors.manager.msg_code == JERR_OUT_OF_MEMORY) throw std::bad_alloc();
        throw Error(ErrorKind::output, std::string("cannot encode the image as JPEG: ") + errors.message +
                                           "; choose PNG textures or a smaller export.texture_max_px");
    }

    JpegErrors errors = {};
    jpeg_compress_struct jpeg = {};
    JpegSink sink;
    jvirt_barray_ptr (*request)(j_common_ptr, int, boolean, JDIMENSION, JDIMENSION, JDIMENSION) = nullptr;
    std::array<jvirt_barray_ptr, kMostComponents> arrays = {};
    int array_count = 0;
    std::array<std::vector<JBLOCKROW>, kMostComponents> rows;  // of blocks
};

// Notes where libjpeg keeps the blocks of each component.
jvirt_barray_ptr note_array(j_common_ptr object, int pool, boolean zeroed, JDIMENSION columns,
                            JDIMENSION rows, JDIMENSION at_once) {
    auto& coder = *static_cast<Encoder*>(object->client_data);
    const jvirt_barray_ptr array = coder.request(object, pool, zeroed, columns, rows, at_once);
    if (coder.array_count < kMostComponents) coder.arrays[coder.array_count++] = array;
    return array;
}

void begin(Encoder& coder, const Image& picture, int width, int height, const JpegSettings& settings) {
    jpeg_compress_struct& jpeg = coder.jpeg;
    jpeg_create_compress(&jpeg);
    jpeg.dest = &coder.sink.manager;
    jpeg.image_width = static_cast<JDIMENSION>(width);
    jpeg.image_height = static_cast<JDIMENSION>(height);
    jpeg.input_components = picture.channels;
    jpeg.in_color_space = picture.channels == 1 ? JCS_GRAYSCALE : JCS_RGB;
    jpeg_set_defaults(&jpeg);
    settings.prepare(jpeg);
}

// Makes the blocks of a strip. Declares a progressive file whose only scan holds means: then libjpeg keeps
// all blocks, and counts of them the fewest symbols, which are not used. Separate from its caller, as all
// that longjmp returns to.
bool blocks_step(Encoder& coder, const Image& picture, const PixelRect& strip, const JpegSettings& settings,
                 jpeg_scan_info& scan, JSAMPARRAY lines) {
    if (setjmp(coder.errors.jump)) return false;
    jpeg_compress_struct& jpeg = coder.jpeg;
    begin(coder, picture, strip.width, strip.height, settings);
    scan.comps_in_scan = jpeg.num_components;
    for (int c = 0; c < jpeg.num_components; ++c) scan.component_index[c] = c;
    jpeg.scan_info = &scan;
    jpeg.num_scans = 1;
    coder.request = jpeg.mem->request_virt_barray;
    jpeg.mem->request_virt_barray = note_array;
    jpeg_start_compress(&jpeg, TRUE);
    jpeg_write_scanlines(&jpeg, lines, jpeg.image_height);
    return true;
}

bool rows_step(Encoder& coder) {
    if (setjmp(coder.errors.jump)) return false;
    for (int c = 0; c < coder.jpeg.num_components; ++c)
        for (JDIMENSION row = 0; row < coder.rows[c].size(); ++row)
            coder.rows[c][row] = coder.jpeg.mem->access_virt_barray(
                reinterpret_cast<j_common_ptr>(&coder.jpeg), coder.arrays[c], row, 1, FALSE)[0];
    return true;
}

// Writes a file's bytes up to its scan: that is what libjpeg does before the first line.
bool header_step(Encoder& coder, const Image& picture, const PixelRect& part, const JpegSettings& settings,
                 const JpegCodes& codes) {
    if (setjmp(coder.errors.jump)) return false;
    jpeg_compress_struct& jpeg = coder.jpeg;
    begin(coder, picture, part.width, part.height, settings);
    for (std::size_t table = 0; table < kJpegTables; ++table)
        for (std::size_t k = 0; k < 2; ++k) {
            const JpegCode& code = codes[2 * table + k];
            JHUFF_TBL& to = *(k == 0 ? jpeg.dc_huff_tbl_ptrs : jpeg.ac_huff_tbl_ptrs)[table];
            std::copy(code.lengths.begin(), code.lengths.end(), to.bits);
            std::copy(code.symbols.begin(), code.symbols.end(), to.huffval);
        }
    jpeg_start_compress(&jpeg, TRUE);
    JSAMPROW none = nullptr;
    jpeg_write_scanlines(&jpeg, &none, 0);
    return true;
}

// Appends the blocks in the order of a scan: unit by unit of all components, or row by row of the only one.
void add_blocks(const Encoder& coder, JpegSymbols& symbols) {
    const jpeg_compress_struct& jpeg = coder.jpeg;
    const bool is_single = jpeg.num_components == 1;
    const auto units = [&](JDIMENSION blocks, int factor) { return (blocks + factor - 1) / factor; };
    const jpeg_component_info& first = jpeg.comp_info[0];
    const int across = is_single ? 1 : first.h_samp_factor, down = is_single ? 1 : first.v_samp_factor;
    const JDIMENSION columns = units(first.width_in_blocks, across),
                     rows = units(first.height_in_blocks, down);
    const auto add_unit = [&](JDIMENSION x, JDIMENSION y) {
        for (int c = 0; c < jpeg.num_components; ++c) {
            const jpeg_component_info& info = jpeg.comp_info[c];
            const JDIMENSION width = is_single ? 1 : info.h_samp_factor,
                             height = is_single ? 1 : info.v_samp_factor;
            for (JDIMENSION row = y * height; row < (y + 1) * height; ++row)
                for (JDIMENSION column = x * width; column < (x + 1) * width; ++column)
                    if (row < info.height_in_blocks && column < info.width_in_blocks)
                        symbols.add(c, coder.rows[c][row][column]);
                    else
                        symbols.add_border(c);
        }
    };
    for (JDIMENSION y = 0; y < rows; ++y)
        for (JDIMENSION x = 0; x < columns; ++x) add_unit(x, y);
}

JpegSymbols symbols_of(const Image& picture, const PixelRect& part, int first_row,
                       const JpegSettings& settings) {
    const PixelRect strip{part.x, part.y + first_row, part.width,
                          std::min(kStripRows, part.height - first_row)};
    std::vector<JSAMPROW> lines;
    for (int y = 0; y < strip.height; ++y)
        lines.push_back(const_cast<JSAMPROW>(picture.at(strip.x, strip.y + y)));
    Encoder coder;
    jpeg_scan_info scan = {};
    if (!blocks_step(coder, picture, strip, settings, scan, lines.data())) coder.fail();
    std::size_t blocks = 0;
    for (int c = 0; c < coder.jpeg.num_components; ++c) {
        const jpeg_component_info& info = coder.jpeg.comp_info[c];
        coder.rows[c].resize(info.height_in_blocks);
        blocks += std::size_t{info.height_in_blocks} * info.width_in_blocks;
    }
    if (!rows_step(coder)) coder.fail();
    for (int c = 0; settings.replace && c < coder.jpeg.num_components; ++c) {
        const jpeg_component_info& info = coder.jpeg.comp_info[c];
        const JDIMENSION before = first_row / DCTSIZE * info.v_samp_factor / coder.jpeg.max_v_samp_factor;
        for (JDIMENSION row = 0; row < info.height_in_blocks; ++row)
            settings.replace(c, before + row, coder.rows[c][row], info.width_in_blocks);
    }
    JpegSymbols symbols(blocks);
    add_blocks(coder, symbols);
    return symbols;
}

}  // namespace

std::vector<std::uint8_t> encode_baseline_jpeg(const Image& picture, const PixelRect& part,
                                               const JpegSettings& settings, int threads) {
    if (part.height > JPEG_MAX_DIMENSION) {  // no strip is
        Encoder tall;
        header_step(tall, picture, part, settings, {});
        tall.fail();
    }
    const std::size_t strips = (part.height + kStripRows - 1) / kStripRows;
    ThreadPool pool(std::min(threads, static_cast<int>(strips)));
    std::vector<JpegSymbols> symbols(strips, JpegSymbols(0));
    pool.parallel_for_chunks<1>(strips, [&](std::size_t i) {
        symbols[i] = symbols_of(picture, part, static_cast<int>(i) * kStripRows, settings);
    });
    for (std::size_t i = 0; i < strips; ++i) symbols[i].follow(i > 0 ? &symbols[i - 1] : nullptr);
    const JpegCodes codes = optimal_jpeg_codes(symbols);
    Encoder header;
    if (!header_step(header, picture, part, settings, codes)) header.fail();
    std::vector<std::uint8_t> file = std::move(header.sink.bytes);
    file.resize(file.size() - header.sink.manager.free_in_buffer);
    append_jpeg_scan(file, symbols, codes, pool);
    file.insert(file.end(), {0xff, JPEG_EOI});
    return file;
}

}  // namespace hexrelief::exporters
