// The flags of eight pixels of a row in one word, for loops over pixels without a branch on each. Reading
// needs seven bytes more than a map has pixels, see PixelSurfaces::flags.
#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>
#include <cstring>

#include "mesher/surface/pixels/crack_edges_step.h"

namespace hexrelief::surface {

static_assert(std::endian::native == std::endian::little, "the first pixel's flags are the lowest byte");

// Returns a word with `flag` in each of its eight bytes.
constexpr std::uint64_t in_each_of_eight(std::uint8_t flag) {
    return 0x0101010101010101u * flag;
}
inline constexpr std::uint64_t kCracksOfEight =
    in_each_of_eight(step::kDiscontinuityRight | step::kDiscontinuityDown);

// Reads the flags of eight pixels.
inline std::uint64_t eight_flags(const std::uint8_t* flags) {
    std::uint64_t eight;
    std::memcpy(&eight, flags, sizeof eight);
    return eight;
}
// Returns a mask of all bits of the first `count` pixels, count >= 1; of all eight if `count` is more.
inline std::uint64_t first_of_eight(int count) {
    return ~std::uint64_t{0} >> 8 * (8 - std::min(count, 8));
}

// Calls visit(crack) for the crack edges of pixels first .. end - 1 of a row, in order, right before down.
template <typename Visit>
void each_crack(const step::PixelView& map, int y, int first, int end, const Visit& visit) {
    const std::uint8_t* const flags = map.flags + map.index(0, y);
    for (int x = first; x < end; x += 8)
        for (std::uint64_t cracks = eight_flags(flags + x) & first_of_eight(end - x) & kCracksOfEight;
             cracks != 0; cracks &= cracks - 1) {
            const int bit = std::countr_zero(cracks);
            visit(step::Crack{x + bit / 8, y, bit % 8});
        }
}

}  // namespace hexrelief::surface
