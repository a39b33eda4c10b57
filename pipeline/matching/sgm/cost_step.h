// The matching cost of two pixels: census and truncated colour difference.
#pragma once

#include <cstdint>

#include "pipeline/base/host_device.h"
#include "pipeline/matching/common/halves_step.h"

namespace hexrelief::step {

// The census transform of a 9x7 window (Zabih & Woodfill 1994): for each pixel except the centre a bit that
// says whether it is darker than the centre. Only the number of different bits counts, so each backend may
// order the bits as it likes.
inline constexpr int kCensusRadiusX = 4, kCensusRadiusY = 3, kCensusBits = 62;
inline constexpr int kCensusWeight = 3;
inline constexpr std::uint8_t kColorCut = 40;  // a channel's difference counts up to this

template <typename Word>
HEXRELIEF_HD Word cut_difference(Word difference) {
    return least_of(difference, in_halves<Word>(kColorCut));
}

// Returns the cost of one pixel of the right picture, 0..206, or of two in the halves of a word. hamming:
// 0..62; differences: the sum over three channels, or the one of a grey pair, each truncated.
template <typename Word>
HEXRELIEF_HD Word matching_cost(Word hamming, Word differences, int channels) {
    const auto colors = static_cast<Word>(differences >> (channels == 3 ? 3 : 1));
    return static_cast<Word>(kCensusWeight * hamming + (colors & in_halves<Word>(0xff)));
}

}  // namespace hexrelief::step
