// The slope of a surface at a pixel: disparity per pixel along x and y, in 1/256.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>

#include "mesher/common/host_device.h"
#include "pipeline/matching/common/color_step.h"

namespace hexrelief::step {

inline constexpr int kSlopeOne = 256;                  // 1 px of disparity per pixel
inline constexpr int kSteepest = 512;                  // slopes are limited to this
inline constexpr int kSamples = 4, kLeastSamples = 4;  // of a line's fit: most per side, least in total
inline constexpr int kSlopeRadius = 2;                 // of the window over which slopes are averaged
inline constexpr int kLineStep = 20;  // 1/16 px: a larger change from pixel to pixel ends a line
// 1/16 px: neighbours whose disparities differ by more belong to another surface.
inline constexpr int kSlopeSurface = 24;

// All of these numbers fit into 16 bits. CPUs keep them in 16 bits, so that a vector holds more of them;
// devices use Int = int, because their registers have 32 bits and truncating each result would cost an
// instruction, or keep two of them in a word (cuda/matching/refine/slopes.cu).

// True for every other pixel of a window, as the dark squares of a chessboard. The result without the other
// pixels looks the same after smoothing.
HEXRELIEF_HD constexpr bool is_dark(int i, int j) {
    return (i + j) % 2 == 0;
}

// Returns all bits set if true, none if false: selects numbers in vectorised loops.
template <typename Int = std::int16_t>
HEXRELIEF_HD Int mask_of(bool condition) {
    return condition ? Int{-1} : Int{0};
}
template <typename Int>
HEXRELIEF_HD Int distance_between(Int a, Int b) {
    return static_cast<Int>((a > b ? a : b) - (a > b ? b : a));
}

// The sums of a line fitted through the disparities beside a pixel: numbers of samples before and behind
// it, at distances t = -1, -2, .. and 1, 2, ..; sums of v, their disparities relative to the pixel's own,
// and of t v.
template <typename Int>
struct LineSums {
    Int before = 0, behind = 0, v = 0, tv = 0;
};

// Returns whether the run of one surface reaches the next sample, as a mask; `on` is the mask
// of the sample before.
template <typename Int>
HEXRELIEF_HD Int run_reaches(Int on, Int value, Int before) {
    return on & mask_of<Int>((value >= 0) & (distance_between<Int>(value, before) <= kLineStep));
}

// Adds a sample if the mask `on` is set. v: its disparity, t px away, less the pixel's own. side: the number
// of samples on its side.
template <typename Int>
HEXRELIEF_HD void add_sample(Int& side, Int& sum_v, Int& sum_tv, Int t, Int v, Int on) {
    const auto counted = static_cast<Int>(v & on);
    side = static_cast<Int>(side - on);
    sum_v = static_cast<Int>(sum_v + counted);
    sum_tv = static_cast<Int>(sum_tv + t * counted);
}

// Returns floor(sum / count + 1/2), count > 0. The floats hold integers below 2^24 and are divided once: the
// result is the same everywhere.
HEXRELIEF_HD int rounded_quotient(float sum, float count) {
    const float quotient = (sum + 0.5f * count) / count;
    const int whole = static_cast<int>(quotient);
    return whole - (static_cast<float>(whole) > quotient);
}

// The terms of a line's fit that depend only on the samples' positions, the pixel's own included: their
// number n, the sum of t, and n times the sum of t^2 less the square of the sum of t.
struct LinePlaces {
    int n, t, denominator;

    HEXRELIEF_HD constexpr LinePlaces(int before, int behind)
        : n(1 + before + behind),
          t((behind * (behind + 1) - before * (before + 1)) / 2),
          denominator(n * (squares(before) + squares(behind)) - t * t) {}

  private:
    HEXRELIEF_HD static constexpr int squares(int k) { return k * (k + 1) * (2 * k + 1) / 6; }
};

// Returns the slope of the least squares line, in 1/256.
template <typename Int>
HEXRELIEF_HD Int slope_of(const LineSums<Int>& s) {
    const LinePlaces places(s.before, s.behind);
    const int slope = rounded_quotient(static_cast<float>(16 * (places.n * s.tv - places.t * s.v)),
                                       static_cast<float>(places.denominator > 1 ? places.denominator : 1));
    const int cut = slope > kSteepest ? kSteepest : slope < -kSteepest ? -kSteepest : slope;
    return places.n >= kLeastSamples ? static_cast<Int>(cut) : Int{0};
}

// Computes floor(x / divisor + 1/2) for integers x with |x| <= 512 * divisor and divisor < 2^11,
// without a division. A quarter of 1 / divisor is added, so that rounding errors never put an exact
// quotient below its value.
struct Reciprocal {
    float scale, half;

    Reciprocal() = default;
    HEXRELIEF_HD constexpr Reciprocal(int factor, int divisor)
        : scale(static_cast<float>(factor) / static_cast<float>(divisor)),
          half(0.5f + 0.25f / static_cast<float>(divisor)) {}
    // Returns factor * x / divisor, rounded.
    HEXRELIEF_HD int rounded(int x) const {
        return static_cast<int>(floorf(fmaf(static_cast<float>(x), scale, half)));
    }
};
// The terms of slope_of(), precomputed for one of the few possible numbers of samples before and behind.
struct alignas(16) LineFit {
    std::int16_t n, t;
    Reciprocal reciprocal;

    LineFit() = default;
    HEXRELIEF_HD constexpr LineFit(int before, int behind) : n(0), t(0), reciprocal(0, 1) {
        const LinePlaces places(before, behind);
        if (places.n < kLeastSamples) return;
        n = static_cast<std::int16_t>(places.n);
        t = static_cast<std::int16_t>(places.t);
        reciprocal = Reciprocal(16, places.denominator);
    }
    HEXRELIEF_HD int slope(int v, int tv) const {
        const int slope = reciprocal.rounded(n * tv - t * v);
        return slope > kSteepest ? kSteepest : slope < -kSteepest ? -kSteepest : slope;
    }
};
struct LineFits {
    LineFit fits[kSamples + 1][kSamples + 1];  // indexed by the numbers of samples before and behind
};
HEXRELIEF_HD constexpr LineFits line_fits() {
    LineFits all{};
    for (int before = 0; before <= kSamples; ++before)
        for (int behind = 0; behind <= kSamples; ++behind) all.fits[before][behind] = LineFit(before, behind);
    return all;
}

// Returns the mean slope of `count` pixels on one surface, those among the dark pixels of a 5x5 window.
template <typename Int>
HEXRELIEF_HD std::int16_t mean_slope(Int sum, Int count) {
    return static_cast<std::int16_t>(
        rounded_quotient(static_cast<float>(sum), static_cast<float>(count > 1 ? count : 1)));
}
// Reciprocals of all possible counts, for the same mean without a division; a window has
// at most kMostSlopes pixels.
inline constexpr int kMostSlopes = 13;
struct MeanSlopes {
    Reciprocal of_count[kMostSlopes + 1];
};
HEXRELIEF_HD constexpr MeanSlopes mean_slopes() {
    MeanSlopes all{};
    for (int count = 0; count <= kMostSlopes; ++count)
        all.of_count[count] = Reciprocal(1, count > 1 ? count : 1);
    return all;
}
template <typename Int>
HEXRELIEF_HD Int on_same_surface(Int value, Int own) {
    return mask_of<Int>((value >= 0) & (distance_between<Int>(value, own) <= kSlopeSurface));
}

// Returns the change of a plane's disparity from a pixel with these slopes to the pixel (dx, dy) px away;
// both offsets must be in -30 .. 30, so that 16 bits hold the result.
template <typename Int>
HEXRELIEF_HD Int plane_offset(Int slope_x, Int slope_y, Int dx, Int dy) {
    return static_cast<Int>(static_cast<Int>(slope_x * dx + slope_y * dy) >> 4);
}

}  // namespace hexrelief::step
