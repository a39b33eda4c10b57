#include "pipeline/evaluation/evaluate_parts.h"

#include <algorithm>
#include <cmath>

namespace hexrelief::evaluation {
namespace {

constexpr float kAgreement_px = 1.01f;  // one px, plus rounding

constexpr int kReach_px = 3;  // windows of 7x7

// Combines the values of each pixel's window by choose(), along rows first, then along columns.
template <typename Value, typename Choose>
std::vector<Value> over_windows(const std::vector<Value>& values, int width, int height, Choose choose) {
    const auto pass = [&](const std::vector<Value>& from, int step_x, int step_y) {
        std::vector<Value> to = from;
        for (int y = 0; y < height; ++y)
            for (int x = 0; x < width; ++x)
                for (int k = -kReach_px; k <= kReach_px; ++k) {
                    const int nx = x + k * step_x, ny = y + k * step_y;
                    if (nx < 0 || nx >= width || ny < 0 || ny >= height) continue;
                    Value& value = to[static_cast<std::size_t>(y) * width + x];
                    value = choose(value, from[static_cast<std::size_t>(ny) * width + nx]);
                }
        return to;
    };
    return pass(pass(values, 1, 0), 0, 1);
}

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

}  // namespace

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

EdgeCounts count_edges(const DisparityMap& map, const DisparityMap& truth, float discontinuity_px) {
    const auto largest = [](auto a, auto b) { return std::max(a, b); };
    const auto smallest = [](auto a, auto b) { return std::min(a, b); };
    const auto with_unknown = [&](float value) {
        std::vector<float> values = truth.values;
        for (float& d : values) d = is_given(d) ? d : value;
        return values;
    };
    const int width = truth.width, height = truth.height;
    const auto near_edge =
        over_windows(find_discontinuities(truth, discontinuity_px), width, height, largest);
    const auto front = over_windows(with_unknown(-kUnknownDisparity), width, height, largest);
    const auto back = over_windows(with_unknown(kUnknownDisparity), width, height, smallest);
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

}  // namespace hexrelief::evaluation
