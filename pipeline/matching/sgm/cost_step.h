// How badly two pixels match (recipe: census and truncated colour difference).
#pragma once

#include <cstdint>

#include "mesher/common/host_device.h"
#include "pipeline/matching/common/raster.h"

namespace hexrelief::step {

// The census transform of a 9x7 window (Zabih & Woodfill 1994): bit k, in row order without the centre, says
// that the k-th pixel is darker than the centre. 62 bits.
inline constexpr int kCensusRadiusX = 4, kCensusRadiusY = 3, kCensusBits = 62;
inline constexpr int kCensusWeight = 3;
inline constexpr std::uint8_t kColorCut = 40;  // a channel's difference counts up to this

HEXRELIEF_HD std::uint64_t census(RasterView<const std::uint8_t> grey, int x, int y) {
    std::uint64_t bits = 0;
    int bit = 0;
    const std::uint8_t centre = grey.at(x, y);
    for (int j = -kCensusRadiusY; j <= kCensusRadiusY; ++j)
        for (int i = -kCensusRadiusX; i <= kCensusRadiusX; ++i) {
            if (i == 0 && j == 0) continue;
            bits |= static_cast<std::uint64_t>(grey.at(x + i, y + j) < centre) << bit++;
        }
    return bits;
}

HEXRELIEF_HD std::uint8_t cut_difference(std::uint8_t a, std::uint8_t b) {
    const std::uint8_t larger = a > b ? a : b, smaller = a > b ? b : a;
    const auto difference = static_cast<std::uint8_t>(larger - smaller);
    return difference < kColorCut ? difference : kColorCut;
}

// The sum of the cut differences of three channels, which are the lower bytes of words.
HEXRELIEF_HD std::uint8_t cut_differences(std::uint32_t a, std::uint32_t b) {
#ifdef __CUDA_ARCH__
    const std::uint32_t differences = __vabsdiffu4(a, b), cut = kColorCut * 0x10001u;
    const std::uint32_t even = __vminu2(differences & 0xff00ffu, cut);  // two bytes as 16-bit numbers
    const std::uint32_t both = even + __vminu2(differences >> 8 & 0xff00ffu, cut);
    return static_cast<std::uint8_t>(both + (both >> 16));
#else
    int sum = 0;
    for (int shift = 0; shift < 24; shift += 8)
        sum += cut_difference(static_cast<std::uint8_t>(a >> shift), static_cast<std::uint8_t>(b >> shift));
    return static_cast<std::uint8_t>(sum);
#endif
}

// hamming: 0..62; differences: the sum over three channels, or the one of a grey pair, each cut. 0..206.
HEXRELIEF_HD std::uint8_t matching_cost(std::uint8_t hamming, std::uint8_t differences, int channels) {
    return static_cast<std::uint8_t>(kCensusWeight * hamming + (differences >> (channels == 3 ? 3 : 1)));
}

}  // namespace hexrelief::step
