// The boxes that HEIC files are made of (ISO/IEC 14496-12).
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <string_view>

namespace hexrelief::readers::codec {

using Bytes = std::span<const std::uint8_t>;

// Removes a big-endian number from the front and returns it; bytes beyond the end count as 0.
inline std::uint64_t take(Bytes& bytes, int count) {
    std::uint64_t value = 0;
    for (int i = 0; i < count; ++i) {
        value = value << 8 | (bytes.empty() ? 0 : bytes.front());
        bytes = bytes.subspan(bytes.empty() ? 0 : 1);
    }
    return value;
}

// Calls visit(type, content) for each box. A box that claims to be longer than the rest ends with it.
template <typename Visit>
void each_box(Bytes bytes, const Visit& visit) {
    while (bytes.size() >= 8) {
        Bytes rest = bytes;
        std::uint64_t size = take(rest, 4);
        const std::string_view type(reinterpret_cast<const char*>(rest.data()), 4);
        rest = rest.subspan(4);
        if (size == 1) size = take(rest, 8);
        const std::uint64_t header = bytes.size() - rest.size();
        if (size == 0) size = bytes.size();
        size = std::clamp<std::uint64_t>(size, header, bytes.size());
        visit(type, bytes.subspan(header, size - header));
        bytes = bytes.subspan(size);
    }
}

}  // namespace hexrelief::readers::codec
