#include <algorithm>
#include <cmath>
#include <cstddef>

#include "pipeline/base/thread_pool.h"
#include "pipeline/matching/common/color_step.h"
#include "pipeline/matching/matcher.h"

namespace hexrelief::matching {
namespace {

constexpr int kParts = 8;
constexpr std::size_t kLeastPoints = 256;

using Levels = std::vector<std::uint8_t>;
struct MatchedLevels {
    Levels left, right;
};

// Instead of a channel: the luminance.
constexpr int kGrey = -1;
std::uint8_t level_at(const Image& image, std::size_t pixel, int channel) {
    const std::uint8_t* at = &image.pixels[pixel * image.channels];
    if (channel != kGrey) return at[channel];
    return image.channels == 1 ? at[0] : step::luminance(at[0], at[1], at[2]);
}

MatchedLevels levels_of(const StereoPair& pair, const MatchedMap& map, int min_px, int channel) {
    const Image &left = pair.left, &right = pair.right;
    MatchedLevels levels;
    for (int y = 0; y < left.height; ++y)
        for (int x = 0; x < left.width; ++x) {
            const std::size_t row = static_cast<std::size_t>(y) * left.width;
            const int disparity = map.disparities[row + x];
            if (!map.is_matched[row + x]) continue;
            const int seen = x - min_px - (disparity + kOnePixel / 2) / kOnePixel;
            if (seen < 0 || seen >= right.width) continue;
            levels.left.push_back(level_at(left, row + x, channel));
            levels.right.push_back(level_at(right, row + seen, channel));
        }
    return levels;
}

// Returns the mean of each eighth of the sorted levels, darkest first.
std::array<double, kParts> means_of(Levels& levels) {
    std::sort(levels.begin(), levels.end());
    std::array<double, kParts> means{};
    for (std::size_t k = 0; k < kParts; ++k) {
        const std::size_t begin = levels.size() * k / kParts, end = levels.size() * (k + 1) / kParts;
        for (std::size_t i = begin; i < end; ++i) means[k] += levels[i];
        means[k] /= static_cast<double>(end - begin);
    }
    return means;
}

// Maps a level of the right picture. Below the mean of the darkest eighth the curve is a line through black,
// above that of the lightest eighth a shift.
double level_on_left(double level, const std::array<double, kParts>& left,
                     const std::array<double, kParts>& right) {
    if (level <= right.front()) return right.front() > 0 ? level * left.front() / right.front() : level;
    if (level >= right.back()) return level + left.back() - right.back();
    const auto above = std::lower_bound(right.begin(), right.end(), level);
    const auto k = static_cast<std::size_t>(above - right.begin());
    return left[k - 1] + (level - right[k - 1]) / (right[k] - right[k - 1]) * (left[k] - left[k - 1]);
}

}  // namespace

LightCurves find_light(const StereoPair& pair, const MatchedMap& map, int min_px) {
    const bool as_grey = pair.left.channels != pair.right.channels;
    const int count = as_grey ? 1 : pair.left.channels;
    LightCurves curves;
    for (int channel = 0; channel < count; ++channel) {
        MatchedLevels levels = levels_of(pair, map, min_px, as_grey ? kGrey : channel);
        if (levels.left.size() < kLeastPoints) return {};
        const auto left = means_of(levels.left), right = means_of(levels.right);
        curves.emplace_back();
        for (int level = 0; level < 256; ++level)
            curves.back()[static_cast<std::size_t>(level)] = static_cast<std::uint8_t>(
                std::clamp(std::lround(level_on_left(level, left, right)), 0L, 255L));
    }
    return curves;
}

void relight(Image& right, const LightCurves& curves, int threads) {
    if (curves.empty()) return;
    const auto channels = static_cast<std::size_t>(right.channels);
    ThreadPool(threads).parallel_for(
        right.pixels.size() / channels, [&](std::size_t first, std::size_t last) {
            for (std::size_t channel = 0; channel < channels; ++channel)
                for (std::size_t i = first * channels + channel; i < last * channels; i += channels)
                    right.pixels[i] = curves[std::min(channel, curves.size() - 1)][right.pixels[i]];
        });
}

}  // namespace hexrelief::matching
