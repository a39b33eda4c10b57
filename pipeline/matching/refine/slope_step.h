// How a surface is inclined at a pixel: disparity per pixel along x and y, in 1/256.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>

#include "mesher/common/host_device.h"
#include "pipeline/matching/common/color_step.h"

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
// or two of them in a word (cuda/matching/refine/slopes.cu).

// Every other pixel of a window, as the dark squares of a chessboard: what they lack, smoothing does not
// show.
HEXRELIEF_HD constexpr bool is_dark(int i, int j) {
    return (i + j) % 2 == 0;
}

// All bits where true, none where false: selects numbers in loops that become vectors.
template <typename Int = std::int16_t>
HEXRELIEF_HD Int mask_of(bool condition) {
    return condition ? Int{-1} : Int{0};
}
template <typename Int>
HEXRELIEF_HD Int distance_between(Int a, Int b) {
    return static_cast<Int>((a > b ? a : b) - (a > b ? b : a));
}

// A line fitted through the disparities beside a pixel: how many samples there are on either side, at
// distances t = -1, -2, .. and 1, 2, .. from it; sums of their disparities v relative to the pixel's own.
template <typename Int>
struct LineSums {
    Int before = 0, behind = 0, v = 0, tv = 0;
};

// Whether the run of one surface reaches the next sample; `on`: whether it reached the one before.
template <typename Int>
HEXRELIEF_HD Int run_reaches(Int on, Int value, Int before) {
    return on & mask_of<Int>((value >= 0) & (distance_between<Int>(value, before) <= kLineStep));
}

// v: how much larger the disparity t px away is; counts where `on`. side: of the sums' counts.
template <typename Int>
HEXRELIEF_HD void add_sample(Int& side, Int& sum_v, Int& sum_tv, Int t, Int v, Int on) {
    const auto counted = static_cast<Int>(v & on);
    side = static_cast<Int>(side - on);
    sum_v = static_cast<Int>(sum_v + counted);
    sum_tv = static_cast<Int>(sum_tv + t * counted);
}

// floor(sum / count + 1/2), count > 0. Floats of whole numbers below 2^24, one division: the same everywhere.
HEXRELIEF_HD int rounded_quotient(float sum, float count) {
    const float quotient = (sum + 0.5f * count) / count;
    const int whole = static_cast<int>(quotient);
    return whole - (static_cast<float>(whole) > quotient);
}

// What the places of a line's samples alone tell: their number, the pixel's own among them, the sum of t, and
// n times that of its squares less the square of the sum.
struct LinePlaces {
    int n, t, denominator;

    HEXRELIEF_HD constexpr LinePlaces(int before, int behind)
        : n(1 + before + behind),
          t((behind * (behind + 1) - before * (before + 1)) / 2),
          denominator(n * (squares(before) + squares(behind)) - t * t) {}

  private:
    HEXRELIEF_HD static constexpr int squares(int k) { return k * (k + 1) * (2 * k + 1) / 6; }
};

// The slope of the least squares line, in 1/256.
template <typename Int>
HEXRELIEF_HD Int slope_of(const LineSums<Int>& s) {
    const LinePlaces places(s.before, s.behind);
    const int slope = rounded_quotient(static_cast<float>(16 * (places.n * s.tv - places.t * s.v)),
                                       static_cast<float>(places.denominator > 1 ? places.denominator : 1));
    const int cut = slope > kSteepest ? kSteepest : slope < -kSteepest ? -kSteepest : slope;
    return places.n >= kLeastSamples ? static_cast<Int>(cut) : Int{0};
}

// floor(x / divisor + 1/2) for whole numbers x with |x| <= 512 divisors, divisor < 2^11, without a division:
// a quarter of 1 / divisor more, so that no whole quotient falls below itself.
struct Reciprocal {
    float scale, half;

    Reciprocal() = default;
    HEXRELIEF_HD constexpr Reciprocal(int factor, int divisor)
        : scale(static_cast<float>(factor) / static_cast<float>(divisor)),
          half(0.5f + 0.25f / static_cast<float>(divisor)) {}
    // factor * x / divisor, rounded.
    HEXRELIEF_HD int rounded(int x) const {
        return static_cast<int>(floorf(fmaf(static_cast<float>(x), scale, half)));
    }
};
// slope_of() by what is known of each of the few ways in which samples can lie.
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
    LineFit fits[kSamples + 1][kSamples + 1];  // by the samples before and behind
};
HEXRELIEF_HD constexpr LineFits line_fits() {
    LineFits all{};
    for (int before = 0; before <= kSamples; ++before)
        for (int behind = 0; behind <= kSamples; ++behind) all.fits[before][behind] = LineFit(before, behind);
    return all;
}

// The mean slope of the pixels on the same surface, of the dark ones of a 5x5 window.
template <typename Int>
HEXRELIEF_HD std::int16_t mean_slope(Int sum, Int count) {
    return static_cast<std::int16_t>(
        rounded_quotient(static_cast<float>(sum), static_cast<float>(count > 1 ? count : 1)));
}
// The same by the count's reciprocal, of as many as a window has at most.
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

// What a plane's disparity changes by from a pixel with these slopes to one that lies (dx, dy) px away. |dx|,
// |dy| <= 30, so that 16 bits hold it.
template <typename Int>
HEXRELIEF_HD Int plane_offset(Int slope_x, Int slope_y, Int dx, Int dy) {
    return static_cast<Int>(static_cast<Int>(slope_x * dx + slope_y * dy) >> 4);
}

}  // namespace hexrelief::step
