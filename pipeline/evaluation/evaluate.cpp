#include "pipeline/evaluation/evaluate.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "pipeline/base/opencv_squares.h"
#include "pipeline/data/error.h"
#include "pipeline/data/number_text.h"

namespace hexrelief::evaluation {
namespace {

bool is_given(float d) {
    return DisparityMap::known(d) && d != 0;
}

// Returns the distance between windows: larger pictures have larger discontinuities, and
// need no denser windows.
int roughness_step_px(double discontinuity_px) {
    return static_cast<int>(std::clamp(std::round(4 * discontinuity_px), 1.0, 64.0));
}

void check_size(const DisparityMap& map, const std::string& name, const DisparityMap& truth) {
    if (map.width == truth.width && map.height == truth.height) return;
    throw Error(ErrorKind::input, name + " is " + size_text(map.width, map.height) + ", its ground truth " +
                                      size_text(truth.width, truth.height) + "; give two maps of one size");
}

double percent(long long part, long long whole) {
    return whole > 0 ? 100.0 * part / whole : 0;
}

constexpr float kAgreement_px = 1.01f;  // one px, plus rounding

constexpr int kReach_px = 3;  // windows of 7x7

// Returns 1 for pixels with a direct neighbour that is known and differs by more than the limit.
std::vector<std::uint8_t> find_discontinuities(const DisparityMap& truth, float limit_px) {
    std::vector<std::uint8_t> found(truth.values.size());
    const auto compare = [&](std::size_t a, std::size_t b) {
        const float da = truth.values[a], db = truth.values[b];
        if (is_given(da) && is_given(db) && std::fabs(da - db) > limit_px) found[a] = found[b] = 1;
    };
    for (int y = 0; y < truth.height; ++y)
        for (int x = 0; x < truth.width; ++x) {
            const std::size_t i = static_cast<std::size_t>(y) * truth.width + x;
            if (x > 0) compare(i, i - 1);
            if (y > 0) compare(i, i - truth.width);
        }
    return found;
}

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

// Returns for each pixel 1 if the truth is known and the right view sees the pixel as well, else 0: by the
// right view's truth, or, if that is null, by the left view's truth.
std::vector<std::uint8_t> find_nonoccluded(const DisparityMap& truth, const DisparityMap* right_truth) {
    const int width = truth.width;
    std::vector<std::uint8_t> nonoccluded(truth.values.size());
    std::vector<float> nearest(width);
    for (int y = 0; y < truth.height; ++y) {
        // Returns the column of the right view in which the pixel is seen; outside the
        // view for unknown pixels.
        const auto right_column = [&](int x) {
            return is_given(truth.at(x, y)) ? x - static_cast<int>(std::nearbyint(truth.at(x, y))) : -1;
        };
        std::fill(nearest.begin(), nearest.end(), -kUnknownDisparity);
        for (int x = 0; x < width && !right_truth; ++x)
            if (const int xr = right_column(x); xr >= 0 && xr < width)
                nearest[xr] = std::max(nearest[xr], truth.at(x, y));
        for (int x = 0; x < width; ++x) {
            const int xr = right_column(x);
            if (xr < 0 || xr >= width) continue;
            const float d = truth.at(x, y);
            nonoccluded[static_cast<std::size_t>(y) * width + x] =
                right_truth ? is_given(right_truth->at(xr, y)) &&
                                  std::fabs(right_truth->at(xr, y) - d) <= kAgreement_px
                            : d >= nearest[xr] - kAgreement_px;
        }
    }
    return nonoccluded;
}

struct EdgeCounts {
    long long pixels = 0, wrong = 0, unknown = 0;
};

EdgeCounts count_edges(const DisparityMap& map, const DisparityMap& truth, float discontinuity_px) {
    const auto with_unknown = [&](float value) {
        std::vector<float> values = truth.values;
        for (float& d : values) d = is_given(d) ? d : value;
        return values;
    };
    const int width = truth.width, height = truth.height;
    std::vector<std::uint8_t> near_edge = find_discontinuities(truth, discontinuity_px);
    std::vector<float> front = with_unknown(-kUnknownDisparity), back = with_unknown(kUnknownDisparity);
    take_largest(near_edge, width, height, kReach_px);
    take_largest(front, width, height, kReach_px);
    take_least(back, width, height, kReach_px);
    EdgeCounts counts;
    for (std::size_t i = 0; i < truth.values.size(); ++i) {
        // Marked pixels lie on both sides of a discontinuity; some windows contain only one side of it.
        if (!near_edge[i] || !is_given(truth.values[i]) || !(front[i] - back[i] > discontinuity_px)) continue;
        ++counts.pixels;
        const float middle = (front[i] + back[i]) / 2;
        if (!is_given(map.values[i]))
            ++counts.unknown;
        else
            counts.wrong += (map.values[i] > middle) != (truth.values[i] > middle);
    }
    return counts;
}

struct Roughness {
    double rms_px = 0;
    long long windows = 0;
};

// Measures the roughness on windows that start at every step_px-th column and row.
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

void count_errors(DisparityEvaluation& result, const DisparityMap& map, const DisparityMap& truth,
                  const DisparityMap* right_truth) {
    const std::vector<std::uint8_t> nonoccluded = find_nonoccluded(truth, right_truth);
    long long known = 0, bad[4] = {}, bad_nonoccluded[4] = {};
    double sum = 0, squares = 0;
    for (std::size_t i = 0; i < truth.values.size(); ++i) {
        if (!is_given(truth.values[i])) continue;
        ++result.truth_pixels;
        result.nonoccluded_pixels += nonoccluded[i];
        double error = std::numeric_limits<double>::infinity();
        if (is_given(map.values[i])) {
            error = std::fabs(static_cast<double>(map.values[i]) - truth.values[i]);
            ++known;
            sum += error;
            squares += error * error;
        }
        for (int k = 0; k < 4; ++k) {
            bad[k] += error > kBadThresholds_px[k];
            bad_nonoccluded[k] += nonoccluded[i] && error > kBadThresholds_px[k];
        }
    }
    for (int k = 0; k < 4; ++k) {
        result.bad_percent[k] = percent(bad[k], result.truth_pixels);
        result.bad_nonoccluded_percent[k] = percent(bad_nonoccluded[k], result.nonoccluded_pixels);
        result.bad_known_percent[k] = percent(bad[k] - (result.truth_pixels - known), known);
    }
    result.coverage_percent = percent(known, result.truth_pixels);
    if (known > 0) {
        result.average_error_px = sum / known;
        result.rms_error_px = std::sqrt(squares / known);
    }
}

}  // namespace

DisparityEvaluation evaluate_disparity(const DisparityMap& map, const DisparityMap& truth,
                                       const EvaluationConfig& config) {
    check_size(map, "the disparity map", truth);
    if (config.right_truth) check_size(*config.right_truth, "the right view's ground truth", truth);
    if (!(config.discontinuity_px > 0))
        throw Error(ErrorKind::usage, "the least discontinuity must be above 0 px");
    DisparityEvaluation result;
    count_errors(result, map, truth, config.right_truth);
    if (result.truth_pixels == 0)
        throw Error(ErrorKind::input,
                    "the ground truth has no known pixel; check its scale and unknown value");
    const EdgeCounts edges = count_edges(map, truth, static_cast<float>(config.discontinuity_px));
    result.edge_pixels = edges.pixels;
    result.edge_wrong_percent = percent(edges.wrong, edges.pixels);
    result.edge_unknown_percent = percent(edges.unknown, edges.pixels);
    const Roughness roughness = measure_roughness(map, truth, roughness_step_px(config.discontinuity_px));
    result.roughness_px = roughness.rms_px;
    result.roughness_windows = roughness.windows;
    return result;
}

nlohmann::ordered_json evaluation_json(const DisparityEvaluation& e) {
    nlohmann::ordered_json json;
    json["bad_0.5_percent"] = e.bad_percent[0];
    json["bad_1_percent"] = e.bad_percent[1];
    json["bad_2_percent"] = e.bad_percent[2];
    json["bad_4_percent"] = e.bad_percent[3];
    json["average_error_px"] = e.average_error_px;
    json["rms_error_px"] = e.rms_error_px;
    json["coverage_percent"] = e.coverage_percent;
    json["truth_pixels"] = e.truth_pixels;
    json["bad_1_nonoccluded_percent"] = e.bad_nonoccluded_percent[1];
    json["bad_2_nonoccluded_percent"] = e.bad_nonoccluded_percent[2];
    json["bad_2_known_percent"] = e.bad_known_percent[2];
    json["nonoccluded_pixels"] = e.nonoccluded_pixels;
    json["edge_wrong_percent"] = e.edge_wrong_percent;
    json["edge_unknown_percent"] = e.edge_unknown_percent;
    json["edge_pixels"] = e.edge_pixels;
    json["roughness_px"] = e.roughness_px;
    json["roughness_windows"] = e.roughness_windows;
    return json;
}

}  // namespace hexrelief::evaluation
