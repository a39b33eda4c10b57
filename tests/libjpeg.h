// JPEG files as libjpeg itself encodes and decodes them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <vector>
// libjpeg's header needs stdio first.
#include <jpeglib.h>

#include "pipeline/data/image.h"

namespace hexrelief::test {

// Encodes a picture: 1 channel is grey, 3 are RGB, 4 CMYK. prepare(jpeg_compress_struct&) is called after the
// defaults are set.
template <typename Prepare>
std::vector<std::uint8_t> encoded_by_libjpeg(const Image& image, const Prepare& prepare) {
    jpeg_compress_struct jpeg = {};
    jpeg_error_mgr errors = {};
    jpeg.err = jpeg_std_error(&errors);
    jpeg_create_compress(&jpeg);
    unsigned char* data = nullptr;
    unsigned long size = 0;
    jpeg_mem_dest(&jpeg, &data, &size);
    jpeg.image_width = static_cast<JDIMENSION>(image.width);
    jpeg.image_height = static_cast<JDIMENSION>(image.height);
    jpeg.input_components = image.channels;
    jpeg.in_color_space = image.channels == 1 ? JCS_GRAYSCALE : image.channels == 4 ? JCS_CMYK : JCS_RGB;
    jpeg_set_defaults(&jpeg);
    prepare(jpeg);
    jpeg_start_compress(&jpeg, TRUE);
    while (jpeg.next_scanline < jpeg.image_height) {
        JSAMPROW row = const_cast<JSAMPROW>(image.at(0, static_cast<int>(jpeg.next_scanline)));
        jpeg_write_scanlines(&jpeg, &row, 1);
    }
    jpeg_finish_compress(&jpeg);
    jpeg_destroy_compress(&jpeg);
    std::vector<std::uint8_t> out(data, data + size);
    std::free(data);
    return out;
}

struct DecodedJpeg {
    Image image;
    bool progressive = false;
    int largest_sampling = 0;
};

inline DecodedJpeg decoded_by_libjpeg(const std::vector<std::uint8_t>& bytes) {
    jpeg_decompress_struct jpeg = {};
    jpeg_error_mgr errors = {};
    jpeg.err = jpeg_std_error(&errors);
    jpeg_create_decompress(&jpeg);
    jpeg_mem_src(&jpeg, bytes.data(), static_cast<unsigned long>(bytes.size()));
    jpeg_read_header(&jpeg, TRUE);
    jpeg_start_decompress(&jpeg);
    const int width = static_cast<int>(jpeg.output_width), height = static_cast<int>(jpeg.output_height);
    DecodedJpeg out{{width, height, jpeg.output_components, {}}, jpeg.progressive_mode != 0, 0};
    for (int i = 0; i < jpeg.num_components; ++i)
        if (jpeg.comp_info[i].h_samp_factor > out.largest_sampling)
            out.largest_sampling = jpeg.comp_info[i].h_samp_factor;
    out.image.pixels.resize(static_cast<std::size_t>(width) * height * jpeg.output_components);
    while (jpeg.output_scanline < jpeg.output_height) {
        JSAMPROW row = out.image.at(0, static_cast<int>(jpeg.output_scanline));
        jpeg_read_scanlines(&jpeg, &row, 1);
    }
    jpeg_finish_decompress(&jpeg);
    jpeg_destroy_decompress(&jpeg);
    return out;
}

}  // namespace hexrelief::test
