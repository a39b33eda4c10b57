// How a surface is inclined at a pixel: disparity per pixel along x and y, in 1/256.
#pragma once

#include <cstdint>

#include "mesher/common/host_device.h"
#include "pipeline/matching/common/halves_step.h"

namespace hexrelief::step {

inline constexpr int kSlopeOne = 256;                  // 1 px of disparity per pixel
inline constexpr int kSteepest = 512;                  // slopes are cut to this
inline constexpr int kSamples = 4, kLeastSamples = 4;  // of a line's fit: most on a side, least in all
inline constexpr int kSlopeRadius = 2;                 // of the window whose pixels' slopes are averaged
inline constexpr int kLineStep = 20;  // 1/16 px: a larger change from pixel to pixel ends a line
inline constexpr int kSlopeSurface =
    24;  // 1/16 px: neighbours whose disparities differ by more are another surface

// All of these numbers have 16 bits at most. CPUs keep them in as many, so that a vector holds more of them;
// devices in Int = int, as their registers have 32 bits, and cutting each result would cost an instruction,
// or two of them in a word.

// Every other pixel of a window, as the dark squares of a chessboard: what they lack, smoothing does not
// show.
HEXRELIEF_HD constexpr bool is_dark(int i, int j) {
    return (i + j) % 2 == 0;
}

// All bits where true, none where false: selects numbers in loops that become vectors.
template <typename Int = std::int16_t>
HEXRELIEF_HD Int mask_of(bool condition) {
    return condition ? static_cast<Int>(-1) : Int{0};
}

// Set in disparities that a line may reach: an unknown one, which has it, is then far above all others, which
// are below 2^15 - kLineStep - 1 (see DisparityRange).
inline constexpr std::uint32_t kUnknownBit = 0x8000;

// The samples of a line on one side of a pixel, at distances k = 1, 2, .. kSamples, as far as the run of one
// surface reaches. v: the sum of their disparities above the pixel's own, tv: the same of k times these. Each
// sample also adds kOneSample to v, and kMoreThanOwn, so that no sum is negative. A word holds one line's, or
// two lines' (see halves_step.h).
inline constexpr std::uint32_t kOneSample = 4096, kMoreThanOwn = 128;
static_assert(kSamples * kLineStep < static_cast<int>(kMoreThanOwn));
template <typename Word>
struct SideSums {
    Word on;  // 1: the run goes on; at first, that the pixel's own disparity is known
    Word v = 0, tv = 0;

    // here: the disparity at distance k, with kUnknownBit. before: the one before it, own: the pixel's own,
    // both without.
    HEXRELIEF_HD void add(std::uint32_t k, Word here, Word before, Word own) {
        constexpr std::uint32_t kLeast = kUnknownBit - kLineStep, kBeyond = 2 * kLineStep + 1;
        // the step from the one before, 0 .. kBeyond - 1 if it is small enough
        const Word step = least_of_sum(static_cast<Word>(here - before), in_halves<Word>(0x10000u - kLeast),
                                       in_halves<Word>(kBeyond));
        on = least_of(on, static_cast<Word>(in_halves<Word>(kBeyond) - step));
        const auto counted = static_cast<Word>((here - own) & on * 0xffffu);
        const auto sample = static_cast<Word>(counted - on * (kUnknownBit - kMoreThanOwn - kOneSample));
        v = static_cast<Word>(v + sample);
        tv = static_cast<Word>(tv + k * sample);
    }
};
// A half of such a sum.
struct SideSum {
    int count, sum;  // of v: how many samples there are; of tv: the sum of k

    HEXRELIEF_HD explicit SideSum(std::uint32_t half)
        : count(static_cast<int>(half / kOneSample)),
          sum(static_cast<int>(half % kOneSample) - count * static_cast<int>(kMoreThanOwn)) {}
};

// x times scale, a quotient of whole numbers, rounded (halves up), cut to kSteepest; divisor: of the scale,
// at most 540. kMore is more than what floats leave out, and less than quotients lie apart: no half falls
// below itself.
HEXRELIEF_HD int rounded_slope(int x, float scale) {
    constexpr float kMore = 1.0f / 2560, kOffset = static_cast<float>(kSteepest) + 0.5f + kMore;
    const float from_steepest = static_cast<float>(x) * scale + kOffset;
    constexpr float kMost = 2 * kSteepest;
    const float least = from_steepest < kMost ? from_steepest : kMost;
    return static_cast<int>(least > 0 ? least : 0.0f) - kSteepest;
}

// What the places of a line's samples alone tell: their number, the pixel's own among them, and the sum of t
// (-1, -2, .. before the pixel, 1, 2, .. behind it); 16 over n times the sum of its squares less the square
// of the sum, or 0 of too few samples.
struct LinePlaces {
    std::int16_t n, t;
    float scale;

    LinePlaces() = default;
    HEXRELIEF_HD constexpr LinePlaces(int before, int behind)
        : n(static_cast<std::int16_t>(1 + before + behind)),
          t(static_cast<std::int16_t>((behind * (behind + 1) - before * (before + 1)) / 2)),
          scale(0) {
        const int denominator = n * (squares(before) + squares(behind)) - t * t;
        const float quotient = 16.0f / static_cast<float>(denominator > 1 ? denominator : 1);
        scale = n >= kLeastSamples ? quotient : 0.0f;
    }

  private:
    HEXRELIEF_HD static constexpr int squares(int k) { return k * (k + 1) * (2 * k + 1) / 6; }
};

// The slope of the least squares line, in 1/256; v and tv: sums over both sides.
HEXRELIEF_HD int line_slope(const LinePlaces& places, int v, int tv) {
    return rounded_slope(places.n * tv - places.t * v, places.scale);
}

// The mean slope of the pixels on the same surface, of the dark ones of a 5x5 window: their sum times this.
inline constexpr int kMostSlopes = 13;
HEXRELIEF_HD constexpr float share_of(int count) {
    return 1.0f / static_cast<float>(count > 1 ? count : 1);
}
// Of two known disparities.
template <typename Int>
HEXRELIEF_HD bool is_same_surface(Int value, Int own) {
    const auto difference = static_cast<Int>(value - own);
    return (difference <= kSlopeSurface) & (difference >= -kSlopeSurface);
}

// What a plane's disparity changes by from a pixel with these slopes to one that lies (dx, dy) px away, in
// 1/256 px. |dx|, |dy| <= 30, so that 16 bits hold it.
template <typename Int>
HEXRELIEF_HD Int plane_change(Int slope_x, Int slope_y, Int dx, Int dy) {
    return static_cast<Int>(slope_x * dx + slope_y * dy);
}

}  // namespace hexrelief::step
