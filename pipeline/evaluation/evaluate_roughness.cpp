#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "pipeline/evaluation/evaluate_parts.h"

namespace hexrelief::evaluation {
namespace {

constexpr int kReach = 4, kSide = 2 * kReach + 1, kPixels = kSide * kSide;
// Sum of the squares of the columns, -4..4, over a window; 60 = 2 (1 + 4 + 9 + 16)
constexpr double kSquares = kSide * 60;

// The truth counts as a slanted plane if it deviates from its plane by less than these limits, and
// has a slope within these limits, in px of disparity per px: maps of whole pixels stay within half a
// step of a plane.
constexpr double kLargestDeviation_px = 0.9, kLargestRms_px = 0.32;
constexpr double kLeastSlope = 0.03, kLargestSlope = 2;
// An estimate with a larger range contains a discontinuity.
constexpr float kLargestRange_px = 20;
constexpr double kLargestCounted_px = 2;

using Window = std::array<float, kPixels>;

struct Plane {
    double slope = 0;
    std::array<double, kPixels> deviations;
};

// Returns the window with this top left pixel; nothing if one of its pixels is unknown.
std::optional<Window> window_at(const DisparityMap& map, int left, int top) {
    Window window;
    for (int i = 0; i < kPixels; ++i) {
        window[i] = map.at(left + i % kSide, top + i / kSide);
        if (!is_given(window[i])) return std::nullopt;
    }
    return window;
}

Plane fit_plane(const Window& window) {
    double sum = 0, sum_x = 0, sum_y = 0;
    for (int i = 0; i < kPixels; ++i) {
        const int x = i % kSide - kReach, y = i / kSide - kReach;
        sum += window[i];
        sum_x += x * double(window[i]);
        sum_y += y * double(window[i]);
    }
    const double mean = sum / kPixels, slope_x = sum_x / kSquares, slope_y = sum_y / kSquares;
    Plane plane;
    plane.slope = std::hypot(slope_x, slope_y);
    for (int i = 0; i < kPixels; ++i) {
        const int x = i % kSide - kReach, y = i / kSide - kReach;
        plane.deviations[i] = window[i] - mean - slope_x * x - slope_y * y;
    }
    return plane;
}

bool is_slanted_plane(const Window& window) {
    const Plane plane = fit_plane(window);
    double largest = 0, squares = 0;
    for (const double deviation : plane.deviations) {
        largest = std::max(largest, std::fabs(deviation));
        squares += deviation * deviation;
    }
    return largest < kLargestDeviation_px && std::sqrt(squares / kPixels) < kLargestRms_px &&
           plane.slope > kLeastSlope && plane.slope < kLargestSlope;
}

}  // namespace

Roughness measure_roughness(const DisparityMap& map, const DisparityMap& truth, int step_px) {
    Roughness result;
    double squares = 0;
    for (int top = 0; top + kSide <= truth.height; top += step_px)
        for (int left = 0; left + kSide <= truth.width; left += step_px) {
            const auto true_window = window_at(truth, left, top);
            if (!true_window || !is_slanted_plane(*true_window)) continue;
            const auto window = window_at(map, left, top);
            if (!window) continue;
            const auto [least, most] = std::minmax_element(window->begin(), window->end());
            if (!(*most - *least < kLargestRange_px)) continue;
            ++result.windows;
            for (const double deviation : fit_plane(*window).deviations)
                squares += std::min(deviation * deviation, kLargestCounted_px * kLargestCounted_px);
        }
    if (result.windows > 0) result.rms_px = std::sqrt(squares / (double(kPixels) * result.windows));
    return result;
}

}  // namespace hexrelief::evaluation
