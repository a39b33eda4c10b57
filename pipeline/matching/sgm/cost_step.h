// The matching cost of two pixels: census and truncated colour difference.
#pragma once

#include <cstdint>

#include "mesher/common/host_device.h"

namespace hexrelief::step {

// The census transform of a 9x7 window (Zabih & Woodfill 1994): for each pixel except the centre a bit that
// says whether it is darker than the centre. Only the number of different bits counts, so each backend may
// order the bits as it likes.
inline constexpr int kCensusRadiusX = 4, kCensusRadiusY = 3, kCensusBits = 62;
inline constexpr int kCensusWeight = 3;
inline constexpr std::uint8_t kColorCut = 40;  // a channel's difference counts up to this

HEXRELIEF_HD std::uint8_t cut_difference(std::uint8_t a, std::uint8_t b) {
    const std::uint8_t larger = a > b ? a : b, smaller = a > b ? b : a;
    const auto difference = static_cast<std::uint8_t>(larger - smaller);
    return difference < kColorCut ? difference : kColorCut;
}

// Returns a cost, 0..206. hamming: 0..62. differences: sum over three channels, or the one of a
// grey pair, each truncated.
HEXRELIEF_HD std::uint8_t matching_cost(std::uint8_t hamming, std::uint8_t differences, int channels) {
    return static_cast<std::uint8_t>(kCensusWeight * hamming + (differences >> (channels == 3 ? 3 : 1)));
}

// As matching_cost(), for two costs at once: 16-bit numbers side by side in a word.
HEXRELIEF_HD std::uint32_t matching_costs_of_pair(std::uint32_t hamming, std::uint32_t differences,
                                                  int channels) {
    const int shift = channels == 3 ? 3 : 1;
    return (((kCensusWeight << shift) * hamming + differences) >> shift) & 0x00ff00ffu;
}
// Returns the sums of truncated differences between a pixel and two others, side by side in a word. The three
// channels of each pixel are the lower bytes of a word.
HEXRELIEF_HD std::uint32_t cut_differences_of_pair(std::uint32_t own, std::uint32_t low, std::uint32_t high,
                                                   int channels) {
    std::uint32_t sums = 0;
#ifdef __CUDA_ARCH__
    const std::uint32_t low_differences = __vabsdiffu4(own, low), high_differences = __vabsdiffu4(own, high);
    for (int c = 0; c < channels; ++c)  // byte c of both, with the fourth, which is 0, above each
        sums += __vminu2(__byte_perm(low_differences, high_differences, 0x3430 + 0x101 * c),
                         kColorCut * 0x10001u);
#else
    for (int shift = 0; shift < 8 * channels; shift += 8) {
        const auto byte = [shift](std::uint32_t word) { return static_cast<std::uint8_t>(word >> shift); };
        sums += cut_difference(byte(own), byte(low)) |
                static_cast<std::uint32_t>(cut_difference(byte(own), byte(high))) << 16;
    }
#endif
    return sums;
}

}  // namespace hexrelief::step
