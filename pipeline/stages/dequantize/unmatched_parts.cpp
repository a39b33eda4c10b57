#include "pipeline/stages/dequantize/unmatched_parts.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <vector>

#include "pipeline/base/thread_pool.h"
#include "pipeline/stages/dequantize/square_sums.h"

namespace hexrelief::stages {
namespace {

constexpr int kSide_px = 480;  // of the reduced map
// Shares of the reduced longer side: the radius within which 3/4 of the pixels around a sure one are matched,
// the radius without a sure pixel in the middle of a large part, and how far a sure pixel counts.
constexpr int kSureRadiusShare = 80, kEmptyShare = 40, kAlongRimShare = 10, kReachShare = 8;
constexpr int kPasses = 3;  // along rows and columns, each with a quarter of the reach before
constexpr double kColourStep = 12, kLeastWeight = 1e-12;  // levels
constexpr double kFlattening = 0.05;  // variance of the places, in squared reaches, that draws slopes to 0
constexpr double kMostDeviations = 2;
constexpr float kHides_px = 2, kEven_px = 1;

// Sums over the sure pixels around a pixel, by their weights: 1, x, y, d, xx, xy, yy, xd, yd, dd.
using Moments = std::array<double, 10>;

// The map at a reduced size, at its own disparities, and the picture as means of levels.
struct ReducedMap {
    int by, width, height;
    std::vector<float> values;
    std::vector<std::uint8_t> is_matched, is_sure;
    std::vector<std::array<float, 3>> levels;

    int longer() const { return std::max(width, height); }
    std::size_t at(int x, int y) const { return static_cast<std::size_t>(y) * width + x; }
};

ReducedMap reduced(const DisparityMap& map, const Image& left) {
    const int by = std::max(1, std::max(map.width, map.height) / kSide_px);
    ReducedMap small{by, (map.width + by - 1) / by, (map.height + by - 1) / by, {}, {}, {}, {}};
    for (int y = 0; y < map.height; y += by)
        for (int x = 0; x < map.width; x += by) {
            const std::size_t i = static_cast<std::size_t>(y) * map.width + x;
            small.values.push_back(map.values[i]);
            small.is_matched.push_back(DisparityMap::known(map.values[i]) &&
                                       map.origins[i] == PixelOrigin::matched);
            std::array<float, 3> mean = {};
            int count = 0;
            for (int v = std::max(0, y - by); v < std::min(map.height, y + 2 * by); ++v)
                for (int u = std::max(0, x - by); u < std::min(map.width, x + 2 * by); ++u, ++count)
                    for (int c = 0; c < left.channels; ++c) mean[c] += left.at(u, v)[c];
            for (float& level : mean) level /= static_cast<float>(count);
            small.levels.push_back(mean);
        }
    const SquareSums matched(small.width, small.height, [&](std::size_t i) { return small.is_matched[i]; });
    const int radius = std::max(1, small.longer() / kSureRadiusShare);
    for (std::size_t i = 0; i < small.values.size(); ++i) {
        double pixels = 0;
        small.is_sure.push_back(small.is_matched[i] && 4 * matched.around(i, radius, pixels) >= 3 * pixels);
    }
    return small;
}

// The pixels that a nearer matched surface hides from the right camera.
std::vector<std::uint8_t> hidden_pixels(const ReducedMap& map) {
    constexpr float kNothing = -1e9F;
    std::vector<float> nearest(map.values.size(), kNothing);
    std::vector<std::uint8_t> is_hidden(map.values.size());
    const auto column = [&](int x, std::size_t i) {
        return static_cast<int>(std::lround(x - map.values[i] / static_cast<float>(map.by)));
    };
    for (int y = 0; y < map.height; ++y) {
        for (int x = 0; x < map.width; ++x) {
            const std::size_t i = map.at(x, y);
            if (!map.is_matched[i]) continue;
            const int there = column(x, i);
            for (int u = std::max(0, there - 1); u <= std::min(map.width - 1, there + 1); ++u)
                nearest[map.at(u, y)] = std::max(nearest[map.at(u, y)], map.values[i]);
        }
        for (int x = 0; x < map.width; ++x) {
            const std::size_t i = map.at(x, y);
            if (!DisparityMap::known(map.values[i])) continue;
            const int there = column(x, i);
            is_hidden[i] =
                there >= 0 && there < map.width && nearest[map.at(there, y)] > map.values[i] + kHides_px;
        }
    }
    return is_hidden;
}

// The pixels of squares without sure ones, near the end of what is known.
std::vector<std::uint8_t> large_parts(const ReducedMap& map) {
    std::vector<std::uint8_t> is_open = hidden_pixels(map), is_of_part(map.values.size());
    for (std::size_t i = 0; i < is_open.size(); ++i)
        is_open[i] = DisparityMap::known(map.values[i]) && !map.is_sure[i] && !is_open[i];
    const int radius = std::max(1, map.longer() / kEmptyShare);
    double pixels = 0;
    const SquareSums sure(map.width, map.height, [&](std::size_t i) { return map.is_sure[i]; });
    const SquareSums empty(map.width, map.height,
                           [&](std::size_t i) { return is_open[i] && sure.around(i, radius, pixels) == 0; });
    const SquareSums known(map.width, map.height,
                           [&](std::size_t i) { return DisparityMap::known(map.values[i]); });
    const int rim = std::max(1, map.longer() / kAlongRimShare);
    const double whole = (2.0 * rim + 1) * (2.0 * rim + 1);
    for (std::size_t i = 0; i < is_open.size(); ++i)
        is_of_part[i] =
            is_open[i] && empty.around(i, radius, pixels) > 0 && known.around(i, rim, pixels) < whole;
    return is_of_part;
}

// Solves (1 + reach (differences of neighbours, by their weights)) x = b for a row or column of moments.
void smooth_line(std::vector<Moments>& all, std::size_t first, std::size_t step, int count, double reach,
                 const std::vector<double>& weights) {
    std::vector<double> above(count);
    const auto weight = [&](int i) {
        return i < 0 || i + 1 >= count ? 0 : reach * weights[first + i * step];
    };
    for (int i = 0; i < count; ++i) {
        const double before = weight(i - 1), after = weight(i);
        const double pivot = 1 + before + after - (i > 0 ? before * above[i - 1] : 0);
        above[i] = after / pivot;
        Moments& here = all[first + i * step];
        for (std::size_t k = 0; k < here.size(); ++k)
            here[k] = (here[k] + (i > 0 ? before * all[first + (i - 1) * step][k] : 0)) / pivot;
    }
    for (int i = count - 2; i >= 0; --i)
        for (std::size_t k = 0; k < all[0].size(); ++k)
            all[first + i * step][k] += above[i] * all[first + (i + 1) * step][k];
}

// The weights between each pixel and the next one along a row (step 1) or a column, by the colours two pixels
// around them, as silhouettes are soft.
std::vector<double> weights_along(const ReducedMap& map, bool is_row) {
    std::vector<double> weights(map.values.size());
    const std::size_t step = is_row ? 1 : static_cast<std::size_t>(map.width);
    for (int y = 0; y < map.height; ++y)
        for (int x = 0; x < map.width; ++x) {
            const int i = is_row ? x : y, count = is_row ? map.width : map.height;
            if (i + 1 >= count) continue;
            const auto& low = map.levels[map.at(x, y) - (i > 0 ? step : 0)];
            const auto& high = map.levels[map.at(x, y) + (i + 2 < count ? 2 : 1) * step];
            float difference = 0;
            for (int c = 0; c < 3; ++c) difference = std::max(difference, std::abs(high[c] - low[c]));
            const double share = difference / kColourStep, odds = 1 / (1 + share * share);
            weights[map.at(x, y)] = std::max(odds * odds * odds * odds, kLeastWeight);
        }
    return weights;
}

std::vector<Moments> moments_of(const ReducedMap& map, double reach, float origin, int threads) {
    std::vector<Moments> all(map.values.size());
    for (std::size_t i = 0; i < all.size(); ++i) {
        if (!map.is_sure[i]) continue;
        const double x = static_cast<double>(i % map.width) / reach,
                     y = static_cast<double>(i / map.width) / reach, d = map.values[i] - origin;
        all[i] = {1, x, y, d, x * x, x * y, y * y, x * d, y * d, d * d};
    }
    const std::vector<double> across = weights_along(map, true), down = weights_along(map, false);
    ThreadPool pool(threads);
    for (int round = 1; round <= kPasses; ++round) {
        const double spread = 1.5 * reach * reach * (1 << 2 * (kPasses - round)) / ((1 << 2 * kPasses) - 1);
        pool.parallel_for(static_cast<std::size_t>(map.height), [&](std::size_t begin, std::size_t end) {
            for (std::size_t y = begin; y < end; ++y)
                smooth_line(all, y * map.width, 1, map.width, spread, across);
        });
        pool.parallel_for(static_cast<std::size_t>(map.width), [&](std::size_t begin, std::size_t end) {
            for (std::size_t x = begin; x < end; ++x)
                smooth_line(all, x, static_cast<std::size_t>(map.width), map.height, spread, down);
        });
    }
    return all;
}

// Returns the value of the plane through what the moments are of, at a place.
double on_plane(Moments m, double x, double y) {
    for (std::size_t k = 1; k < m.size(); ++k) m[k] /= m[0];
    const double xx = m[4] - m[1] * m[1] + kFlattening, xy = m[5] - m[1] * m[2],
                 yy = m[6] - m[2] * m[2] + kFlattening, xd = m[7] - m[1] * m[3], yd = m[8] - m[2] * m[3];
    const double deviation = std::sqrt(std::max(m[9] - m[3] * m[3], 0.0)), most = kMostDeviations * deviation;
    const double determinant = xx * yy - xy * xy;
    const double rise = ((xd * yy - yd * xy) * (x - m[1]) + (yd * xx - xd * xy) * (y - m[2])) / determinant;
    return m[3] + std::clamp(rise, -most, most);
}

}  // namespace

DisparityMap with_unmatched_parts_continued(DisparityMap map, const Image& left, int threads) {
    if (map.origins.empty() || left.empty()) return map;
    ReducedMap small = reduced(map, left);
    const std::vector<std::uint8_t> is_of_part = large_parts(small);
    float least = kUnknownDisparity, most = -kUnknownDisparity;
    for (std::size_t i = 0; i < small.values.size(); ++i) {
        if (!small.is_sure[i]) continue;
        least = std::min(least, small.values[i]);
        most = std::max(most, small.values[i]);
    }
    if (!(least <= most)) return map;
    const double reach = static_cast<double>(small.longer()) / kReachShare;
    const std::vector<Moments> moments = moments_of(small, reach, least, threads);
    for (std::size_t i = 0; i < moments.size(); ++i)
        if (moments[i][0] > 0)
            small.values[i] = std::clamp(
                static_cast<float>(least + on_plane(moments[i], static_cast<double>(i % small.width) / reach,
                                                    static_cast<double>(i / small.width) / reach)),
                least, most);
    for (int y = 0; y < map.height; ++y)
        for (int x = 0; x < map.width; ++x) {
            const std::size_t i = static_cast<std::size_t>(y) * map.width + x;
            const int column = x / small.by, row = y / small.by;
            if (map.origins[i] != PixelOrigin::filled || !is_of_part[small.at(column, row)] ||
                !DisparityMap::known(map.values[i]))
                continue;
            // Between four pixels of one surface it changes evenly.
            const int right = std::min(column + 1, small.width - 1),
                      below = std::min(row + 1, small.height - 1);
            const float a = small.values[small.at(column, row)], b = small.values[small.at(right, row)],
                        c = small.values[small.at(column, below)], d = small.values[small.at(right, below)];
            const float u = static_cast<float>(x % small.by) / static_cast<float>(small.by),
                        v = static_cast<float>(y % small.by) / static_cast<float>(small.by);
            const bool is_one = std::max({a, b, c, d}) - std::min({a, b, c, d}) <= kEven_px;
            const float farther = is_one ? (a * (1 - u) + b * u) * (1 - v) + (c * (1 - u) + d * u) * v : a;
            map.values[i] = std::min(map.values[i], farther);
        }
    return map;
}

}  // namespace hexrelief::stages
