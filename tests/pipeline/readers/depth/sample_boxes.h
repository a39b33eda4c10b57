// Makes the boxes of HEIC files (ISO/IEC 14496-12).
#pragma once

#include "tests/pipeline/readers/sample_files.h"

namespace hexrelief::readers {

inline Bytes big_endian(std::uint64_t value, int count) {
    Bytes bytes;
    for (int i = count - 1; i >= 0; --i) bytes.push_back(static_cast<std::uint8_t>(value >> 8 * i));
    return bytes;
}

// Returns a box; it claims to be longer than it is by `longer`.
inline Bytes box(const char* type, const Bytes& content, int longer = 0) {
    return big_endian(content.size() + 8 + longer, 4) + to_bytes(std::string_view(type, 4)) + content;
}

// Returns a box with a version and flags.
inline Bytes full_box(const char* type, int version, std::uint32_t flags, const Bytes& content) {
    return box(type, big_endian(version, 1) + big_endian(flags, 3) + content);
}

}  // namespace hexrelief::readers
