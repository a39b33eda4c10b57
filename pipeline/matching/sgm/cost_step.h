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
inline constexpr int kColorCut = 40;  // a channel's difference counts up to this

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
    const int difference = a > b ? a - b : b - a;
    return static_cast<std::uint8_t>(difference < kColorCut ? difference : kColorCut);
}

// hamming: 0..62; differences: the sum over three channels, or the one of a grey pair, each cut. 0..206.
HEXRELIEF_HD std::uint8_t matching_cost(std::uint8_t hamming, std::uint8_t differences, int channels) {
    return static_cast<std::uint8_t>(kCensusWeight * hamming + (differences >> (channels == 3 ? 3 : 1)));
}

}  // namespace hexrelief::step
