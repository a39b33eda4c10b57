// Smoothing along the planes of a disparity map.
#pragma once

#include <cstdint>

#include "mesher/common/host_device.h"
#include "pipeline/matching/refine/slope_step.h"

namespace hexrelief::step {

// 5x5 pixels at strides of 1, 2 and 4 px, as in the a-trous wavelet transform (Dammertz et
// al. 2010).
inline constexpr int kSmoothRadius = 2, kSmoothLevels = 3;
inline constexpr int kSmoothReach = 44;  // 1/16 px off the plane, from which on a pixel has no weight
inline constexpr int kSmoothColor = 20;  // a larger colour step ends a surface

// How far a pixel lies off the plane through another one, its own, which both pixels' slopes tell. change:
// the sum of what both planes change by from the own pixel to it.
template <typename Int>
HEXRELIEF_HD Int off_plane(Int own, Int other, Int change) {
    return static_cast<Int>(other - static_cast<Int>(static_cast<Int>(change + 16) >> 5) - own);
}

// A pixel's weight, without that of its place in the window: the less the farther it is off the plane, by
// which it is kSmoothReach + off_plane(). A word holds one pixel's, or two (see halves_step.h).
template <typename Word>
HEXRELIEF_HD Word nearness(Word off) {
    return least_of_sum_or_0(static_cast<Word>(~off), in_halves<Word>(2 * kSmoothReach + 1), off);
}
// Whether two colours are alike, in few instructions: the largest step of a channel is at most kSmoothColor.
// Channels lie in fields of 10 bits, and the whole is taken from the largest number of 31 bits: so a colour
// with all bits set is 2^31, which is like no other one.
struct PlaneColor {
    static constexpr std::uint32_t kFields = 1u | 1u << 10 | 1u << 20, kLimit = 1u << 9,
                                   kUnknown = 0xffffffffu;
    std::uint32_t less, more;

    // color: a channel a byte.
    HEXRELIEF_HD static std::uint32_t packed(std::uint32_t color) {
        return 0x7fffffffu - ((color & 0xffu) | (color & 0xff00u) << 2 | (color & 0xff0000u) << 4);
    }
    // own: packed, of a pixel with which others are compared.
    HEXRELIEF_HD explicit PlaneColor(std::uint32_t own)
        : less((kLimit - 1 - kSmoothColor) * kFields - own),
          more((kLimit - 1 - kSmoothColor) * kFields + own) {}
    // A channel that differs by more than kSmoothColor reaches kLimit in either of both.
    HEXRELIEF_HD bool unlike(std::uint32_t other) const {
        return ((less + other) | (more - other)) & (kLimit * kFields | 1u << 31);
    }
};

// floor(sum / count + 1/2), count > 0. Floats of whole numbers below 2^24, one division: the same everywhere.
HEXRELIEF_HD int rounded_quotient(float sum, float count) {
    const float quotient = (sum + 0.5f * count) / count;
    const int whole = static_cast<int>(quotient);
    return whole - (static_cast<float>(whole) > quotient);
}

// By the place in the window: 1..9.
template <typename Int>
HEXRELIEF_HD constexpr Int smoothing_kernel(int i, int j) {
    return static_cast<Int>((3 - (i < 0 ? -i : i)) * (3 - (j < 0 ? -j : j)));
}

// The sums over a window: weights, at most 81 * kSmoothReach, and weights times kSmoothReach + off_plane().
template <typename Word>
struct SmoothSums {
    Word weights = 0;
    std::uint32_t offs = 0;

    // near: nearness(off); 0 if the pixel is not known, or of another colour (see kSmoothColor).
    HEXRELIEF_HD void add(Word kernel, Word near, Word off) {
        weights = static_cast<Word>(weights + kernel * near);
        offs += sum_of_products(kernel, near, off);
    }
};
HEXRELIEF_HD std::int16_t smoothed(std::int16_t disparity, std::uint32_t offs, int weights) {
    const int weighted = static_cast<int>(offs) - kSmoothReach * weights;
    const int mean =
        rounded_quotient(static_cast<float>(weighted), static_cast<float>(weights > 1 ? weights : 1));
    const auto moved = static_cast<std::int16_t>(disparity + mean);
    return disparity < 0 ? disparity : moved > 0 ? moved : std::int16_t{0};
}

}  // namespace hexrelief::step
