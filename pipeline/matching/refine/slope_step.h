// The slope of a surface at a pixel: disparity per pixel along x and y, in 1/256.
#pragma once

#include <cstdint>

#include "pipeline/base/host_device.h"
#include "pipeline/matching/common/halves_step.h"

namespace hexrelief::step {

inline constexpr int kSlopeOne = 256;                  // 1 px of disparity per pixel
inline constexpr int kSteepest = 512;                  // slopes are limited to this
inline constexpr int kSamples = 4, kLeastSamples = 4;  // a line's samples: most per side, least in total
// The radius of the window over which slopes are averaged, in strides; and the strides in px. Filling and the
// votes on holes follow planes for 16 px and more, and an error of the slope grows with the distance, so
// lines are averaged there that reach as far around the pixel.
inline constexpr int kSlopeRadius = 2, kNearSlopes_px = 1, kFarSlopes_px = 6;
inline constexpr int kLineStep = 20;  // 1/16 px: a larger change from pixel to pixel ends a line
// 1/16 px: neighbours whose disparities differ by more belong to another surface.
inline constexpr int kSlopeSurface = 24;

// All of these numbers fit into 16 bits. CPUs keep them in 16 bits, so that a vector holds more of them;
// devices use Int = int, because their registers have 32 bits and truncating each result would cost an
// instruction, or keep two of them in a word (halves_step.h).

// True for every other pixel of a window, as the dark squares of a chessboard. The result without the other
// pixels looks the same after smoothing.
HEXRELIEF_HD constexpr bool is_dark(int i, int j) {
    return (i + j) % 2 == 0;
}

// Returns all bits set if true, none if false: selects numbers in vectorised loops.
template <typename Int = std::int16_t>
HEXRELIEF_HD Int mask_of(bool condition) {
    return condition ? static_cast<Int>(-1) : Int{0};
}

// This bit is set in the disparities of a line's samples. An unknown disparity, which is negative and so has
// it already, is then far above all others, which are below 2^15 - kLineStep - 1 (see DisparityRange).
inline constexpr std::uint32_t kUnknownBit = 0x8000;

// The sums over a line's samples on one side of a pixel, at distances k = 1, 2, .. kSamples, as far as the
// run of one surface reaches: v, of their disparities less the pixel's own, and tv, of k times these. Each
// sample also adds kOneSample, which counts it, and kMoreThanOwn, so that no sum is negative. A word holds
// the sums of one line or of two (see halves_step.h).
inline constexpr std::uint32_t kOneSample = 4096, kMoreThanOwn = 128;
static_assert(kSamples * kLineStep < static_cast<int>(kMoreThanOwn));
template <typename Word>
struct SideSums {
    Word on;  // 1: the run goes on; at first, the pixel's own disparity is known
    Word v = 0, tv = 0;

    // Adds the sample at distance k. here: its disparity, with kUnknownBit; before: that of the preceding
    // sample, own: the pixel's own, both without.
    HEXRELIEF_HD void add(std::uint32_t k, Word here, Word before, Word own) {
        constexpr std::uint32_t kLeast = kUnknownBit - kLineStep, kBeyond = 2 * kLineStep + 1;
        // the step from the preceding sample, 0 .. kBeyond - 1 if it is small enough
        const Word step = least_of_sum(static_cast<Word>(here - before), in_halves<Word>(0x10000u - kLeast),
                                       in_halves<Word>(kBeyond));
        on = least_of(on, static_cast<Word>(in_halves<Word>(kBeyond) - step));
        const auto counted = static_cast<Word>((here - own) & on * 0xffffu);
        const auto sample = static_cast<Word>(counted - on * (kUnknownBit - kMoreThanOwn - kOneSample));
        v = static_cast<Word>(v + sample);
        tv = static_cast<Word>(tv + k * sample);
    }
};
// One of these sums, unpacked.
struct SideSum {
    int count, sum;  // count: for v the number of samples, for tv the sum of k

    HEXRELIEF_HD explicit SideSum(std::uint32_t half)
        : count(static_cast<int>(half / kOneSample)),
          sum(static_cast<int>(half % kOneSample) - count * static_cast<int>(kMoreThanOwn)) {}
};

// Returns x * scale, rounded (halves up) and limited to kSteepest. scale: a quotient of integers whose
// divisor is at most 540. kMore exceeds the rounding error of floats and is less than the distance between
// two quotients, so that no exact half falls below itself.
HEXRELIEF_HD int rounded_slope(int x, float scale) {
    constexpr float kMore = 1.0f / 2560, kOffset = static_cast<float>(kSteepest) + 0.5f + kMore;
    const float from_steepest = static_cast<float>(x) * scale + kOffset;
    constexpr float kMost = 2 * kSteepest;
    const float least = from_steepest < kMost ? from_steepest : kMost;
    return static_cast<int>(least > 0 ? least : 0.0f) - kSteepest;
}

// The terms of a line's fit that depend only on the samples' positions, the pixel's own included: their
// number n; the sum of t (-1, -2, .. before the pixel, 1, 2, .. behind it); and 16 over n times the sum of
// t^2 less the square of the sum of t, or 0 for too few samples.
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

// Returns the slope of the least squares line, in 1/256. v, tv: the sums over both sides.
HEXRELIEF_HD int line_slope(const LinePlaces& places, int v, int tv) {
    return rounded_slope(places.n * tv - places.t * v, places.scale);
}

// A window has at most this many pixels whose slopes are averaged: the dark ones of 5x5. Their mean is the
// sum times share_of() their number.
inline constexpr int kMostSlopes = 13;
HEXRELIEF_HD constexpr float share_of(int count) {
    return 1.0f / static_cast<float>(count > 1 ? count : 1);
}
// True if two known disparities belong to one surface.
template <typename Int>
HEXRELIEF_HD bool is_same_surface(Int value, Int own) {
    const auto difference = static_cast<Int>(value - own);
    return (difference <= kSlopeSurface) & (difference >= -kSlopeSurface);
}

// Returns the change of a plane's disparity from a pixel with these slopes to the pixel (dx, dy) px away;
// both offsets must be in -30 .. 30, so that 16 bits hold the result.
template <typename Int>
HEXRELIEF_HD Int plane_change(Int slope_x, Int slope_y, Int dx, Int dy) {
    return static_cast<Int>(slope_x * dx + slope_y * dy);
}

}  // namespace hexrelief::step
