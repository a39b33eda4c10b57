// Looks through flags, of which few are set, eight at a time.
#pragma once

#include <cstdint>
#include <cstring>

namespace hexrelief {

// The first of the bytes from `at` to end - 1 that has one of the bits, or end.
inline std::uint32_t next_with(const std::uint8_t* bytes, std::uint32_t at, std::uint32_t end,
                               std::uint8_t bits) {
    const std::uint64_t all = 0x0101010101010101u * bits;
    for (std::uint64_t eight; at + sizeof eight <= end; at += sizeof eight) {
        std::memcpy(&eight, bytes + at, sizeof eight);
        if (eight & all) break;
    }
    while (at < end && !(bytes[at] & bits)) ++at;
    return at;
}

}  // namespace hexrelief
