// Looks through flags, of which few are set, eight at a time.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>

namespace hexrelief {

// Eight bytes side by side, the first in the lowest lane.
inline constexpr std::uint64_t in_each_lane(std::uint8_t byte) {
    return 0x0101010101010101u * byte;
}
// All bits of the first `count` lanes, count > 0; more than eight stand for eight.
inline std::uint64_t lanes_of(std::size_t count) {
    return count < 8 ? (std::uint64_t{1} << 8 * count) - 1 : ~std::uint64_t{0};
}
// The bytes from `first` on, 0 from `end` on.
inline std::uint64_t eight_at(const std::uint8_t* first, const std::uint8_t* end) {
    std::uint64_t eight = 0;
    if (std::endian::native == std::endian::little && end - first >= 8)
        std::memcpy(&eight, first, 8);
    else
        for (int k = 0; k < 8 && first + k < end; ++k) eight |= std::uint64_t{first[k]} << 8 * k;
    return eight;
}

// The first of the bytes from `at` to end - 1 that has one of the bits, or end.
inline std::uint32_t next_with(const std::uint8_t* bytes, std::uint32_t at, std::uint32_t end,
                               std::uint8_t bits) {
    const std::uint64_t all = in_each_lane(bits);
    for (std::uint64_t eight; at + sizeof eight <= end; at += sizeof eight) {
        std::memcpy(&eight, bytes + at, sizeof eight);
        if (eight & all) break;
    }
    while (at < end && !(bytes[at] & bits)) ++at;
    return at;
}

}  // namespace hexrelief
