// Smoothing along the planes of a disparity map.
#pragma once

#include <cstdint>

#include "pipeline/base/host_device.h"
#include "pipeline/matching/refine/slope_step.h"

namespace hexrelief::step {

// Windows of 5x5 pixels at strides of 1, 2 and 4 px, as in the a-trous wavelet transform
// (Dammertz et al. 2010).
inline constexpr int kSmoothRadius = 2, kSmoothLevels = 3;
inline constexpr int kSmoothReach = 44;  // 1/16 px: pixels this far off the plane have no weight
inline constexpr int kSmoothColor = 20;  // a larger colour step ends a surface

// Returns the distance of another pixel from the plane through the own one. change: the sum of the changes of
// both pixels' planes from the own pixel to the other.
template <typename Int>
HEXRELIEF_HD Int off_plane(Int own, Int other, Int change) {
    return static_cast<Int>(other - static_cast<Int>(static_cast<Int>(change + 16) >> 5) - own);
}

// Returns a pixel's weight without the factor of its position in the window; it decreases with the distance
// from the plane. off: kSmoothReach + off_plane(). A word holds one pixel's or two (see halves_step.h).
template <typename Word>
HEXRELIEF_HD Word nearness(Word off) {
    return least_of_sum_or_0(static_cast<Word>(~off), in_halves<Word>(2 * kSmoothReach + 1), off);
}
// Tells in few instructions whether two colours are alike: the largest step of a channel is at most
// kSmoothColor. Channels lie in fields of 10 bits, and the whole is subtracted from the largest 31-bit
// number, so that a colour with all bits set becomes 2^31, which is like no other colour.
struct PlaneColor {
    static constexpr std::uint32_t kFields = 1u | 1u << 10 | 1u << 20, kLimit = 1u << 9,
                                   kUnknown = 0xffffffffu;
    std::uint32_t less, more;

    // color: one byte per channel.
    HEXRELIEF_HD static std::uint32_t packed(std::uint32_t color) {
        return 0x7fffffffu - ((color & 0xffu) | (color & 0xff00u) << 2 | (color & 0xff0000u) << 4);
    }
    // own: the packed colour of the pixel that others are compared with.
    HEXRELIEF_HD explicit PlaneColor(std::uint32_t own)
        : less((kLimit - 1 - kSmoothColor) * kFields - own),
          more((kLimit - 1 - kSmoothColor) * kFields + own) {}
    // A channel that differs by more than kSmoothColor reaches kLimit in one of the two.
    HEXRELIEF_HD bool unlike(std::uint32_t other) const {
        return ((less + other) | (more - other)) & (kLimit * kFields | 1u << 31);
    }
};

// Returns floor(sum / count + 1/2), count > 0. The floats hold integers below 2^24 and are divided once: the
// result is the same everywhere.
HEXRELIEF_HD int rounded_quotient(float sum, float count) {
    const float quotient = (sum + 0.5f * count) / count;
    const int whole = static_cast<int>(quotient);
    return whole - (static_cast<float>(whole) > quotient);
}

// Returns the factor of the position in the window, 1..9.
template <typename Int>
HEXRELIEF_HD constexpr Int smoothing_kernel(int i, int j) {
    return static_cast<Int>((3 - (i < 0 ? -i : i)) * (3 - (j < 0 ? -j : j)));
}

// The sums over a window: of weights, at most 81 * kSmoothReach, and of weights times
// kSmoothReach + off_plane().
template <typename Word>
struct SmoothSums {
    Word weights = 0;
    std::uint32_t offs = 0;

    // near: nearness(off); 0 if the pixel is unknown or of another colour (see kSmoothColor).
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
