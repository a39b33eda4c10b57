#include "pipeline/stages/dequantize/bare_patches.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <limits>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "pipeline/data/four_neighbours.h"
#include "pipeline/stages/dequantize/noise.h"

namespace hexrelief::stages {
namespace {

constexpr int kColourRadius_px = 2, kSquare = (2 * kColourRadius_px + 1) * (2 * kColourRadius_px + 1);
// Sum over three channels of the difference of neighbours' sums over squares: a bare patch has less.
constexpr int kBare = 4 * kSquare;
constexpr int kSureShare = 100;   // of the longer side: the radius within which 3/4 of the pixels are matched
constexpr int kSmoothShare = 32;  // the same, of the means of what is led to several farther surfaces
constexpr std::size_t kPatchShare = 1000;  // of the picture
constexpr float kRangeShare = 2;
constexpr float kNearer_px = 1;

// Sums of a value of pixels over rectangles.
class Sums {
  public:
    template <class Value>
    Sums(int width, int height, ThreadPool& pool, const Value& value)
        : width_(width), height_(height), sums_((width + std::size_t{1}) * (height + std::size_t{1})) {
        for_rows(pool, height, [&](int y) {
            double row = 0;
            for (int x = 0; x < width; ++x)
                sums_[index(x + 1, y + 1)] = row += value(static_cast<std::size_t>(y) * width + x);
        });
        pool.parallel_for(static_cast<std::size_t>(width), [&](std::size_t first, std::size_t end) {
            for (int y = 1; y < height; ++y)
                for (int x = static_cast<int>(first); x < static_cast<int>(end); ++x)
                    sums_[index(x + 1, y + 1)] = sums_[index(x + 1, y)] + sums_[index(x + 1, y + 1)];
        });
    }
    // Returns the sum over the square around a pixel, as far as it lies in the picture, and its pixels.
    double around(std::size_t pixel, int radius, double& pixels) const {
        const int x = static_cast<int>(pixel % width_), y = static_cast<int>(pixel / width_);
        const int left = std::max(x - radius, 0), right = std::min(x + radius + 1, width_);
        const int top = std::max(y - radius, 0), bottom = std::min(y + radius + 1, height_);
        pixels = static_cast<double>(right - left) * (bottom - top);
        return sums_[index(right, bottom)] - sums_[index(left, bottom)] - sums_[index(right, top)] +
               sums_[index(left, top)];
    }

  private:
    std::size_t index(int x, int y) const { return y * (width_ + std::size_t{1}) + x; }
    int width_, height_;
    std::vector<double> sums_;
};

std::vector<std::uint8_t> sure_pixels(const DisparityMap& map, ThreadPool& pool) {
    const auto is_matched = [&](std::size_t i) {
        return DisparityMap::known(map.values[i]) && map.origins[i] == PixelOrigin::matched;
    };
    const Sums matched(map.width, map.height, pool, is_matched);
    const int radius = std::max(map.width, map.height) / kSureShare;
    std::vector<std::uint8_t> sure(map.values.size());
    pool.parallel_for(sure.size(), [&](std::size_t begin, std::size_t end) {
        double pixels = 0;
        for (std::size_t i = begin; i < end; ++i)
            sure[i] = is_matched(i) && 4 * matched.around(i, radius, pixels) >= 3 * pixels;
    });
    return sure;
}

// Returns sums of colours over squares; beyond the border the nearest pixel counts.
cv::Mat colour_sums(const Image& image) {
    const cv::Mat colours(image.height, image.width, CV_8UC(image.channels),
                          const_cast<std::uint8_t*>(image.pixels.data()));  // nothing here writes to it
    const int side = 2 * kColourRadius_px + 1;
    cv::Mat sums;
    cv::boxFilter(colours, sums, CV_16S, {side, side}, {-1, -1}, false, cv::BORDER_REPLICATE);
    return sums;
}

constexpr std::uint32_t kNoSource = ~std::uint32_t{0};

// Returns the sure pixel that leads to each one over the least difference of colours; kNoSource if none does
// within a bare patch.
std::vector<std::uint32_t> flood(const DisparityMap& map, const Image& left, ThreadPool& pool) {
    const cv::Mat colours = colour_sums(left);
    const auto colour = [&](std::size_t pixel) {
        return colours.ptr<std::int16_t>() + pixel * static_cast<std::size_t>(left.channels);
    };
    const std::vector<std::uint8_t> sure = sure_pixels(map, pool);
    std::vector<std::uint32_t> source(sure.size(), kNoSource);
    std::vector<std::int16_t> levels(sure.size(), kBare + 1);
    std::vector<std::vector<std::uint32_t>> waiting(kBare + 1);
    for (std::size_t i = 0; i < sure.size(); ++i) {
        if (!sure[i]) continue;
        source[i] = static_cast<std::uint32_t>(i);
        levels[i] = 0;
        waiting[0].push_back(source[i]);
    }
    for (int level = 0; level <= kBare; ++level)
        for (std::size_t next = 0; next < waiting[level].size(); ++next) {
            const std::uint32_t from = waiting[level][next];
            if (levels[from] < level) continue;
            for_four_neighbours(from, map.width, map.height, [&](std::size_t i) {
                if (level >= levels[i]) return;  // as nearly all of them
                int step = 0;
                for (int c = 0; c < left.channels; ++c) step += std::abs(colour(i)[c] - colour(from)[c]);
                const int reached = std::max(level, step * 3 / left.channels);
                if (reached >= levels[i] || !DisparityMap::known(map.values[i])) return;
                levels[i] = static_cast<std::int16_t>(reached);
                source[i] = source[from];
                waiting[reached].push_back(static_cast<std::uint32_t>(i));
            });
        }
    return source;
}

constexpr int kLeastShare = 60;  // of the longer side: matched pixels that show another surface
constexpr float kStep_px = 1;

// The length of the run of matched pixels from column x on that are one surface; `most` if it is longer.
int matched_run(const DisparityMap& map, std::size_t row, int x, int most) {
    int end = x;
    while (end < map.width && end < x + most && map.origins[row + end] == PixelOrigin::matched &&
           (end == x || std::abs(map.values[row + end] - map.values[row + end - 1]) <= kStep_px))
        ++end;
    return end - x;
}

}  // namespace

DisparityMap with_bare_patches_behind(DisparityMap map, const Image& left, int threads) {
    if (map.origins.empty() || left.empty()) return map;
    ThreadPool pool(threads);
    const std::vector<std::uint32_t> source = flood(map, left, pool);
    float least = std::numeric_limits<float>::infinity(), most = -least;
    for (const float d : map.values) {
        if (!DisparityMap::known(d)) continue;
        least = std::min(least, d);
        most = std::max(most, d);
    }
    if (least > most) return map;
    const double fall = (most - least) / kRangeShare;
    const auto fall_of = [&](std::size_t i) {
        return source[i] == kNoSource ? 0 : map.values[i] - map.values[source[i]];
    };
    std::vector<std::uint8_t> is_seen(source.size()), is_moved = is_seen;
    bool any = false;
    std::vector<std::size_t> patch;
    for (std::size_t seed = 0; seed < source.size(); ++seed) {
        if (is_seen[seed] || fall_of(seed) <= kNearer_px) continue;
        is_seen[seed] = 1;
        patch.assign(1, seed);
        double sum = 0;
        for (std::size_t next = 0; next < patch.size(); ++next) {
            sum += fall_of(patch[next]);
            for_four_neighbours(patch[next], map.width, map.height, [&](std::size_t i) {
                if (is_seen[i] || fall_of(i) <= kNearer_px) return;
                is_seen[i] = 1;
                patch.push_back(i);
            });
        }
        if (patch.size() * kPatchShare >= source.size() && sum >= fall * static_cast<double>(patch.size())) {
            for (const std::size_t i : patch) is_moved[i] = 1;
            any = true;
        }
    }
    if (!any) return map;
    const Sums moved(map.width, map.height, pool, [&](std::size_t i) { return is_moved[i]; });
    const Sums values(map.width, map.height, pool,
                      [&](std::size_t i) { return is_moved[i] ? map.values[source[i]] : 0; });
    const int radius = std::max(map.width, map.height) / kSmoothShare;
    double pixels = 0;
    for (std::size_t i = 0; i < source.size(); ++i)
        if (is_moved[i])
            map.values[i] =
                static_cast<float>(values.around(i, radius, pixels) / moved.around(i, radius, pixels));
    return map;
}

DisparityMap continued_at_right_end(DisparityMap map, const std::vector<std::uint8_t>& is_seen) {
    if (map.origins.empty() || is_seen.empty()) return map;
    const int least = std::max(map.width, map.height) / kLeastShare;
    for (int y = 0; y < map.height; ++y) {
        const std::size_t row = static_cast<std::size_t>(y) * map.width;
        int last = map.width - 1;
        while (last >= 0 && !is_seen[row + last]) --last;
        float before = kUnknownDisparity;
        for (int x = 0; x < map.width; ++x) {
            float& here = map.values[row + x];
            if (!DisparityMap::known(here)) {
                before = kUnknownDisparity;
                continue;
            }
            const bool is_beyond =
                DisparityMap::known(before) && static_cast<float>(x) - before > static_cast<float>(last);
            if (is_beyond && std::abs(here - before) > kStep_px && matched_run(map, row, x, least) < least)
                here = before;
            else
                before = here;
        }
    }
    return map;
}

}  // namespace hexrelief::stages
