// JPEG textures made of the blocks of the JPEG file that a picture was read from.
#pragma once

#include <cstdint>
#include <vector>

#include "pipeline/data/crop.h"
#include "pipeline/data/image.h"

namespace hexrelief::exporters {

// Blocks of a JPEG file are up to this wide and high, px: a part that begins at multiples of it keeps them.
inline constexpr int kJpegBlock_px = 16;

struct JpegOfBlocks {
    std::vector<std::uint8_t> bytes;
    bool keeps_blocks = false;  // the source's own
};

// Encodes a part of a picture as `source` is encoded: with its tables, chroma subsampling and, if the source
// is progressive, scans, without its metadata. If the picture's top left is the source's, pixel by pixel, and
// the part begins at multiples of kJpegBlock_px, the source's own blocks are used there, which loses nothing;
// the picture may go on below it from the next multiple of kJpegBlock_px. Returns no bytes if the source is
// no JPEG of 8 bits in grey or YCbCr, as the picture is, or its blocks are damaged. `part` lies within the
// picture.
JpegOfBlocks encode_jpeg_as(const std::vector<std::uint8_t>& source, const Image& picture,
                            const PixelRect& part, int threads = 1);

}  // namespace hexrelief::exporters
