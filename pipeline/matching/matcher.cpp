#include "pipeline/matching/matcher.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdlib>
#include <utility>

#include "pipeline/base/simd.h"
#include "pipeline/base/thread_pool.h"
#include "pipeline/matching/common/color_planes.h"
#include "pipeline/matching/common/color_step.h"
#include "pipeline/matching/refine/refine.h"
#include "pipeline/matching/sgm/sgm.h"

namespace hexrelief::matching {
namespace {

struct MatchedViews {
    PairColors colors;
    ViewDisparities views;
};

MatchedViews match_in_windows(const StereoPair& pair, const MatchingConfig& config, DisparityView half,
                              ThreadPool& pool) {
    MatchedViews result{split_colors(pair, pool), {}};
    const PairColors& colors = result.colors;
    const SearchWindows windows = find_windows(pair.left.width, pair.left.height, config.range, half, pool);
    result.views =
        match_views(colors.left, colors.right, config.range, windows.view(), config.penalties, pool);
    return result;
}

MatchingConfig at_half_size(MatchingConfig config) {
    config.range = at_half_size(config.range);
    config.consistency = at_half_size(config.consistency);
    return config;
}

// Matches coarse to fine: halves the pair until its range is searched completely, then matches at each larger
// size in windows around the result.
MatchedViews match(const StereoPair& pair, const MatchingConfig& config, ThreadPool& pool) {
    if (is_searched_wholly(config.range)) return match_in_windows(pair, config, {}, pool);
    const MatchedViews half =
        match({matching::at_half_size(pair.left, pool), matching::at_half_size(pair.right, pool)},
              at_half_size(config), pool);
    return match_in_windows(pair, config, half.views.left.view(), pool);
}

ConsistencyConfig consistency_of(const MatchingConfig& config) {
    ConsistencyConfig consistency = config.consistency;
    consistency.min_px = config.range.min_px;
    return consistency;
}

FrameSegments frame_segments_of(const StereoPair& pair, const MatchingConfig& config) {
    return find_frame_segments(pair.left, config.range.min_px + config.range.count);
}

MatchedMap without_border(const RefinedMap& map) {
    const DisparityView disparities = map.disparities.view();
    const RasterView<const std::uint8_t> matched = map.is_matched.view();
    MatchedMap result{disparities.width, disparities.height, {}, {}};
    for (int y = 0; y < result.height; ++y) {
        const std::int16_t* row = disparities.row(y);
        result.disparities.insert(result.disparities.end(), row, row + result.width);
        result.is_matched.insert(result.is_matched.end(), matched.row(y), matched.row(y) + result.width);
    }
    return result;
}

constexpr int kBlock_px = 16;
constexpr int kDarkest = 5, kLightest = 250;  // beyond these levels noise is cut off

// Returns the mean absolute second difference of a block's pixels along both axes, which slopes do not
// affect; negative if a tenth of the levels or more are next to black or white.
double roughness(const Image& image, int x0, int y0) {
    const int channels = image.channels, samples = kBlock_px * kBlock_px * channels;
    int sum = 0, cut = 0;
    for (int y = y0; y < y0 + kBlock_px; ++y) {
        const std::uint8_t *above = image.at(0, y - 1), *own = image.at(0, y), *below = image.at(0, y + 1);
        for (int i = x0 * channels; i < (x0 + kBlock_px) * channels; ++i) {
            const auto across = [&](const std::uint8_t* row) {
                return row[i - channels] - 2 * row[i] + row[i + channels];
            };
            sum += std::abs(across(above) - 2 * across(own) + across(below));
            cut += own[i] <= kDarkest || own[i] >= kLightest;
        }
    }
    return 10 * cut < samples ? static_cast<double>(sum) / samples : -1;
}

constexpr int kRadius_px = 2;
// 16 exp(-r^2 / (2 * 1.5^2)), indexed by the squared distance.
constexpr int kNearness[2 * kRadius_px * kRadius_px + 1] = {16, 13, 10, 0, 7, 5, 0, 0, 3};

// Replaces each pixel by the weighted mean of the pixels around it; weights grow with nearness
// and similarity of colour.
HEXRELIEF_SMALL_VECTORS void denoise_row(const ColorView& colors, int y, int other_color,
                                         std::uint8_t* __restrict out) {
    constexpr int kLanes = 32;
    const int channels = colors.channels, width = colors.planes[0].width;
    for (int x0 = 0; x0 < width; x0 += kLanes) {
        std::uint32_t sums[3][kLanes] = {}, weights[kLanes] = {};
        for (int j = -kRadius_px; j <= kRadius_px; ++j)
            for (int i = -kRadius_px; i <= kRadius_px; ++i) {
                int step[kLanes] = {};
                for (int c = 0; c < channels; ++c) {
                    const std::uint8_t* own = colors.planes[c].row(y) + x0;
                    const std::uint8_t* other = colors.planes[c].row(y + j) + x0 + i;
                    for (int k = 0; k < kLanes; ++k) step[k] = std::max(step[k], std::abs(own[k] - other[k]));
                }
                const int nearness = kNearness[i * i + j * j];
                for (int k = 0; k < kLanes; ++k) step[k] = nearness * std::max(0, other_color - step[k]);
                for (int c = 0; c < channels; ++c) {
                    const std::uint8_t* other = colors.planes[c].row(y + j) + x0 + i;
                    for (int k = 0; k < kLanes; ++k)
                        sums[c][k] += static_cast<std::uint32_t>(step[k]) * other[k];
                }
                for (int k = 0; k < kLanes; ++k) weights[k] += static_cast<std::uint32_t>(step[k]);
            }
        // The numbers are integers below 2^24: the quotient is the same on every processor.
        for (int c = 0; c < channels; ++c)
            for (int k = 0; k < std::min(kLanes, width - x0); ++k)
                out[(x0 + k) * channels + c] = static_cast<std::uint8_t>(
                    static_cast<float>(sums[c][k]) / static_cast<float>(weights[k]) + 0.5f);
    }
}

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

MatchedMap match_pair(const StereoPair& pair, const MatchingConfig& config, int threads) {
    ThreadPool pool(threads);
    const MatchingConfig half_config = at_half_size(config);
    const MatchedViews half =
        match({matching::at_half_size(pair.left, pool), matching::at_half_size(pair.right, pool)},
              half_config, pool);
    const HalfSizeMatches half_size{find_trusted_matches(half.views, consistency_of(half_config), pool).left,
                                    half_config.range.min_px};
    const MatchedViews matched = match_in_windows(pair, config, half.views.left.view(), pool);
    return without_border(refine({frame_segments_of(pair, config), matched.colors, matched.views, &half_size},
                                 consistency_of(config), pool));
}

MatchedMap match_trusted(const StereoPair& pair, const MatchingConfig& config, int threads) {
    ThreadPool pool(threads);
    const MatchedViews matched = match(pair, config, pool);
    TrustedMatches trusted = find_trusted_matches(matched.views, consistency_of(config), pool);
    Raster<std::uint8_t> known = known_pixels(trusted.left, pool);
    return without_border({std::move(trusted.left), std::move(known)});
}

MatchedMap refine_views(const StereoPair& pair, const ViewDisparities& views, const MatchingConfig& config,
                        int threads) {
    ThreadPool pool(threads);
    return without_border(refine({frame_segments_of(pair, config), split_colors(pair, pool), views, nullptr},
                                 consistency_of(config), pool));
}

double find_noise(const Image& image) {
    constexpr double kOfNormal = 0.20888568955258338;  // sqrt(pi / 2) / 6
    std::vector<double> blocks;
    for (int y = 1; y + kBlock_px < image.height; y += kBlock_px)
        for (int x = 1; x + kBlock_px < image.width; x += kBlock_px)
            if (const double rough = roughness(image, x, y); rough >= 0) blocks.push_back(rough);
    if (blocks.empty()) return 0;
    return kOfNormal * value_at_rank(blocks, blocks.size() / 10);
}

void denoise(Image& image, double noise, int threads) {
    constexpr double kLeastNoise = 4, kAlike = 5;  // kAlike in standard deviations
    constexpr int kMostOther = 160;                // keeps sums below 2^24
    if (noise < kLeastNoise) return;
    const int other_color = std::min(kMostOther, static_cast<int>(std::lround(kAlike * noise)));
    ThreadPool pool(threads);
    const ColorPlanes colors = split_colors(image, Channels::as_they_are, pool);
    for_each_row(pool, image.height,
                 [&](int y) { denoise_row(view_of(colors), y, other_color, image.at(0, y)); });
}

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
