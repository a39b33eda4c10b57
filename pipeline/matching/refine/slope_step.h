// How a surface is inclined at a pixel: disparity per pixel along x and y, in 1/256.
#pragma once

#include <cstddef>
#include <cstdint>

#include "mesher/common/host_device.h"
#include "pipeline/matching/common/color_step.h"

namespace hexrelief::step {

inline constexpr int kSlopeOne = 256;    // 1 px of disparity per pixel
inline constexpr int kSteepest = 512;    // slopes are cut to this
inline constexpr int kLeastSamples = 4;  // of a line's fit
inline constexpr int kSlopeSurface =
    24;  // 1/16 px: neighbours whose disparities differ by more are another surface

// All bits where true, none where false: selects numbers in loops that become vectors.
HEXRELIEF_HD std::int16_t mask_of(bool condition) {
    return condition ? std::int16_t{-1} : std::int16_t{0};
}

// A line fitted through the disparities beside a pixel: sums over samples at distances t, of disparities v
// relative to the pixel's own.
struct LineSums {
    std::int16_t n = 1, t = 0, v = 0, tt = 0, tv = 0;
};

// Whether the run of one surface reaches the next sample; `on`: whether it reached the one before.
HEXRELIEF_HD std::int16_t run_reaches(std::int16_t on, std::int16_t value, std::int16_t before,
                                      std::int16_t largest_step) {
    return on & mask_of((value >= 0) & (distance(value, before) <= largest_step));
}

// v: how much larger the disparity t px away is; counts where `on`.
HEXRELIEF_HD void add_sample(LineSums& s, std::int16_t t, std::int16_t v, std::int16_t on) {
    const auto counted = static_cast<std::int16_t>(v & on);
    s.n = static_cast<std::int16_t>(s.n - on);
    s.t = static_cast<std::int16_t>(s.t + (t & on));
    s.v = static_cast<std::int16_t>(s.v + counted);
    s.tt = static_cast<std::int16_t>(s.tt + (t * t & on));
    s.tv = static_cast<std::int16_t>(s.tv + t * counted);
}

// floor(sum / count + 1/2), count > 0. Floats of whole numbers below 2^24, one division: the same everywhere.
HEXRELIEF_HD int rounded_quotient(float sum, float count) {
    const float quotient = (sum + 0.5f * count) / count;
    const int whole = static_cast<int>(quotient);
    return whole - (static_cast<float>(whole) > quotient);
}

// The slope of the least squares line, in 1/256.
HEXRELIEF_HD std::int16_t slope_of(const LineSums& s) {
    const int denominator = s.n * s.tt - s.t * s.t, numerator = s.n * s.tv - s.t * s.v;
    const int slope = rounded_quotient(static_cast<float>(16 * numerator),
                                       static_cast<float>(denominator > 1 ? denominator : 1));
    const int cut = slope > kSteepest ? kSteepest : slope < -kSteepest ? -kSteepest : slope;
    return s.n >= kLeastSamples ? static_cast<std::int16_t>(cut) : std::int16_t{0};
}

// The mean slope of a 5x5 window's pixels on the same surface.
HEXRELIEF_HD std::int16_t mean_slope(std::int16_t sum, std::int16_t count) {
    return static_cast<std::int16_t>(
        rounded_quotient(static_cast<float>(sum), static_cast<float>(count > 1 ? count : 1)));
}
HEXRELIEF_HD std::int16_t on_same_surface(std::int16_t value, std::int16_t own) {
    return mask_of((value >= 0) & (distance(value, own) <= kSlopeSurface));
}

// What a plane's disparity changes by from a pixel with these slopes to one that lies (dx, dy) px away. |dx|,
// |dy| <= 30, so that 16 bits hold it.
HEXRELIEF_HD std::int16_t plane_offset(std::int16_t slope_x, std::int16_t slope_y, std::int16_t dx,
                                       std::int16_t dy) {
    return static_cast<std::int16_t>(static_cast<std::int16_t>(slope_x * dx + slope_y * dy) >> 4);
}

}  // namespace hexrelief::step
