// How a surface is inclined at a pixel: disparity per pixel along x and y, in 1/256.
#pragma once

#include <cstddef>
#include <cstdint>

#include "mesher/common/host_device.h"
#include "pipeline/matching/common/color_step.h"

namespace hexrelief::step {

inline constexpr int kSlopeOne = 256;                  // 1 px of disparity per pixel
inline constexpr int kSteepest = 512;                  // slopes are cut to this
inline constexpr int kSamples = 4, kLeastSamples = 4;  // of a line's fit: most on a side, least in all
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

// The slope of the least squares line, in 1/256.
template <typename Int>
HEXRELIEF_HD Int slope_of(const LineSums<Int>& s) {
    const int before = s.before, behind = s.behind, n = 1 + before + behind;
    const int t = (behind * (behind + 1) - before * (before + 1)) / 2;
    const auto squares = [](int k) { return k * (k + 1) * (2 * k + 1) / 6; };
    const int tt = squares(before) + squares(behind);
    const int denominator = n * tt - t * t, numerator = n * s.tv - t * s.v;
    const int slope = rounded_quotient(static_cast<float>(16 * numerator),
                                       static_cast<float>(denominator > 1 ? denominator : 1));
    const int cut = slope > kSteepest ? kSteepest : slope < -kSteepest ? -kSteepest : slope;
    return n >= kLeastSamples ? static_cast<Int>(cut) : Int{0};
}

// The mean slope of the pixels on the same surface, of the dark ones of a 5x5 window.
template <typename Int>
HEXRELIEF_HD std::int16_t mean_slope(Int sum, Int count) {
    return static_cast<std::int16_t>(
        rounded_quotient(static_cast<float>(sum), static_cast<float>(count > 1 ? count : 1)));
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
