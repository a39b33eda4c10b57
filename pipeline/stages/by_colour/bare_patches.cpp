#include "pipeline/stages/by_colour/bare_patches.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdlib>
#include <opencv2/imgproc.hpp>

#include "pipeline/base/opencv_squares.h"
#include "pipeline/base/thread_pool.h"
#include "pipeline/data/four_neighbours.h"
#include "pipeline/stages/by_colour/colours.h"

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
constexpr int kAnyColour = 3 * 255 * kSquare;
constexpr int kMarginShare = 20;  // of the longer side: beside the right picture's end less is matched
constexpr int kLedShare = 10;     // the same: farther than this colours lead to other things

// Sums of a value of pixels over rectangles.
class Sums {
  public:
    template <class Value>
    Sums(int width, int height, ThreadPool& pool, const Value& value)
        : width_(width), height_(height), sums_((width + std::size_t{1}) * (height + std::size_t{1})) {
        pool.parallel_for_each(height, [&](int y) {
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

constexpr std::uint32_t kNoSource = ~std::uint32_t{0};

// Returns the sure pixel that leads to each one over the least difference of colours; kNoSource where it is
// larger than `most`. is_open(pixel): whether a pixel may be led to.
template <typename Open>
std::vector<std::uint32_t> flood(const DisparityMap& map, const std::vector<std::uint8_t>& sure,
                                 const Image& left, int most, const Open& is_open, ThreadPool& pool) {
    const cv::Mat colours = colour_sums(left, kColourRadius_px, pool);
    const auto colour = [&](std::size_t pixel) {
        return colours.ptr<std::int16_t>() + pixel * static_cast<std::size_t>(left.channels);
    };
    std::vector<std::uint32_t> source(sure.size(), kNoSource);
    std::vector<std::int16_t> levels(sure.size(), static_cast<std::int16_t>(most + 1));
    std::vector<std::vector<std::uint32_t>> waiting(static_cast<std::size_t>(most) + 1);
    for (std::size_t i = 0; i < sure.size(); ++i) {
        if (!sure[i]) continue;
        source[i] = static_cast<std::uint32_t>(i);
        levels[i] = 0;
        waiting[0].push_back(source[i]);
    }
    for (int level = 0; level <= most; ++level)
        for (std::size_t next = 0; next < waiting[level].size(); ++next) {
            const std::uint32_t from = waiting[level][next];
            if (levels[from] < level) continue;
            for_four_neighbours(from, map.width, map.height, [&](std::size_t i) {
                if (level >= levels[i] || !is_open(i)) return;  // as nearly all of them
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

// Sets pixels to 0 that lie in regions of fewer than a thousandth of the picture.
void remove_small_regions(std::vector<std::uint8_t>& pixels, int width, int height) {
    cv::Mat labels, figures, centres;
    cv::connectedComponentsWithStats(cv::Mat(height, width, CV_8U, pixels.data()), labels, figures, centres,
                                     4);
    for (std::size_t i = 0; i < pixels.size(); ++i) {
        const int area = figures.at<int>(labels.ptr<int>()[i], cv::CC_STAT_AREA);
        if (static_cast<std::size_t>(area) * kPatchShare < pixels.size()) pixels[i] = 0;
    }
}

}  // namespace

DisparityMap with_bare_patches_behind(DisparityMap map, const Image& left, int threads) {
    if (map.origins.empty() || left.empty()) return map;
    ThreadPool pool(threads);
    const std::vector<std::uint32_t> source = flood(
        map, sure_pixels(map, pool), left, kBare, [](std::size_t) { return true; }, pool);
    const KnownRange range = known_range(map);
    if (range.is_empty()) return map;
    const double fall = (range.largest - range.least) / kRangeShare;
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

DisparityMap continued_at_right_end(DisparityMap map, const Image& left,
                                    const std::vector<std::uint8_t>& is_seen, int threads) {
    if (map.origins.empty() || left.empty()) return map;
    ThreadPool pool(threads);
    std::vector<std::uint8_t> sure = sure_pixels(map, pool);
    remove_small_regions(sure, map.width, map.height);
    std::vector<std::uint8_t> is_near_sure = sure;
    take_largest(is_near_sure, map.width, map.height, std::max(map.width, map.height) / kSureShare);
    std::vector<std::uint8_t> is_rim(sure.size());
    pool.parallel_for_each(map.height, [&](int y) {
        const std::size_t row = static_cast<std::size_t>(y) * map.width;
        for (int x = map.width - 1; x >= 0 && !sure[row + x]; --x) is_rim[row + x] = 1;
    });
    const int margin = std::max(map.width, map.height) / kMarginShare;
    std::vector<int> ends;  // of the rows of the right picture, less the margin
    for (int y = 0; y < map.height; ++y) {
        int last = map.width - 1;
        while (!is_seen.empty() && last >= 0 && !is_seen[static_cast<std::size_t>(y) * map.width + last])
            --last;
        ends.push_back(last - margin);
    }
    const auto is_beyond = [&](std::size_t i, float d) {
        return static_cast<float>(i % map.width) - d > static_cast<float>(ends[i / map.width]);
    };
    const auto flood_rim = [&] {
        return flood(
            map, sure, left, kAnyColour, [&](std::size_t i) { return is_rim[i] != 0; }, pool);
    };
    const std::vector<std::uint32_t> from_sure = flood_rim();
    for (std::size_t i = 0; i < sure.size(); ++i)
        sure[i] |= is_rim[i] && map.origins[i] == PixelOrigin::filled && !is_beyond(i, map.values[i]);
    const std::vector<std::uint32_t> from_all = flood_rim();
    const std::vector<float> before = map.values;
    const int far = std::max(map.width, map.height) / kLedShare;
    const auto disparity_of = [&](std::size_t i) {
        const int place = static_cast<int>(i), source = static_cast<int>(from_sure[i]);
        const int columns = place % map.width - source % map.width,
                  rows = place / map.width - source / map.width;
        const float led = before[from_sure[i]];
        return columns * columns + rows * rows > far * far ? std::min(led, before[from_all[i]]) : led;
    };
    pool.parallel_for_each(map.height, [&](int y) {
        const std::size_t row = static_cast<std::size_t>(y) * map.width;
        for (std::size_t i = row; i < row + map.width; ++i) {
            const bool stays = map.origins[i] == PixelOrigin::matched && is_near_sure[i] != 0;
            if (!is_rim[i] || stays || from_sure[i] == kNoSource) continue;
            const float d = disparity_of(i);
            if (is_beyond(i, d)) map.values[i] = d;
        }
    });
    return map;
}

}  // namespace hexrelief::stages
