// Makes EXIF data that tell an orientation, by the standard's bytes.
#pragma once

#include "tests/pipeline/readers/sample_files.h"

namespace hexrelief::readers {

// Returns a TIFF directory of one tag.
inline Bytes orientation_exif(int orientation, bool is_big_endian = false) {
    const auto value = static_cast<std::uint8_t>(orientation);
    return is_big_endian ? Bytes{'M', 'M', 0, 42, 0, 0, 0,     8, 0, 1, 0x01, 0x12, 0,
                                 3,   0,   0, 0,  1, 0, value, 0, 0, 0, 0,    0,    0}
                         : Bytes{'I', 'I', 42, 0, 8, 0,     0, 0, 1, 0, 0x12, 0x01, 3,
                                 0,   1,   0,  0, 0, value, 0, 0, 0, 0, 0,    0,    0};
}

// Returns the JPEG file with the EXIF data in front.
inline Bytes with_exif(const Bytes& jpeg, const Bytes& exif) {
    const Bytes content = to_bytes(std::string_view("Exif\0\0", 6)) + exif;
    const std::size_t length = content.size() + 2;
    return Bytes{0xff,
                 0xd8,
                 0xff,
                 0xe1,
                 static_cast<std::uint8_t>(length >> 8),
                 static_cast<std::uint8_t>(length)} +
           content + Bytes(jpeg.begin() + 2, jpeg.end());
}

}  // namespace hexrelief::readers
