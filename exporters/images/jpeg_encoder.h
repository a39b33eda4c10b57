// Encodes baseline JPEG files by several threads.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "exporters/images/jpeg_memory.h"
#include "pipeline/data/crop.h"
#include "pipeline/data/image.h"

namespace hexrelief::exporters {

struct JpegSettings {
    // Sets quantisation and sampling, after jpeg_set_defaults(). May leave by longjmp, as libjpeg does.
    std::function<void(jpeg_compress_struct&)> prepare;
    // May replace blocks of a row of a component of the part, in any thread; may be empty.
    std::function<void(int component, JDIMENSION row, JBLOCKROW blocks, JDIMENSION columns)> replace = {};
};

// Encodes a part of a picture of 1 or 3 channels, with optimal Huffman codes. The bytes do not depend on the
// number of threads; they are libjpeg's own. Throws Error(output) if libjpeg cannot encode the part.
std::vector<std::uint8_t> encode_baseline_jpeg(const Image& picture, const PixelRect& part,
                                               const JpegSettings& settings, int threads);

}  // namespace hexrelief::exporters
