#include "pipeline/stages/disparity_range.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <utility>
#include <vector>

#include "pipeline/data/four_neighbours.h"
#include "pipeline/data/start_work.h"
#include "pipeline/stages/sgbm.h"

namespace hexrelief::stages {
namespace {

constexpr int kCoarseSpeckle = 12, kFineSpeckle = 40;  // largest speckles, in pixels
// The larger match searches up to this many times the largest disparity of the coarse match.
constexpr double kFineReach = 1.6;
// The largest disparity is one that more than this share of the matched pixels reach; the least one,
// correspondingly, one that more than this share do not exceed.
constexpr double kLeastShare = 0.001;
constexpr std::size_t kLeastPixels = 8;
// The margins: a share of the largest or least disparity, plus this many pixels of the small pair.
constexpr double kMargin = 0.06, kNearMargin_px = 1.5, kFarMargin_px = 3;

Image reduced(const Image& image, const cv::Size& size) {
    const cv::Mat full(image.height, image.width, CV_8UC(image.channels),
                       const_cast<std::uint8_t*>(image.pixels.data()));  // nothing here writes to it
    Image result{size.width, size.height, image.channels, {}};
    result.pixels.resize(static_cast<std::size_t>(size.area()) * image.channels);
    cv::Mat small(size, full.type(), result.pixels.data());
    cv::resize(full, small, size, 0, 0, cv::INTER_AREA);
    return result;
}

ReducedPair reduced(const StereoPair& pair, int columns, int threads) {
    const double scale = std::max(1.0, static_cast<double>(pair.left.width) / columns);
    const cv::Size size(cvRound(pair.left.width / scale), std::max(1, cvRound(pair.left.height / scale)));
    auto right = start_work(threads, [&] { return reduced(pair.right, size); });
    Image left = reduced(pair.left, size);
    return {scale, {std::move(left), right.get()}};
}

SmallMatch match_small(ReducedPair small, const matching::DisparityRange& range, int speckle_pixels,
                       int threads) {
    matching::MatchingConfig config;
    config.range = range;
    config.consistency.speckle_pixels = speckle_pixels;
    matching::MatchedMap map = matching::match_trusted(small.pair, config, threads);
    return {std::move(small), range.min_px, std::move(map)};
}

// The least and the largest disparity that more than a few pixels have, in px of the full pair.
struct Extremes {
    double least_px, largest_px;
};
std::optional<Extremes> extremes_of(const SmallMatch& match) {
    // Returns nothing if next to nothing matches.
    std::vector<std::int16_t> known;
    for (const std::int16_t d : match.map.disparities)
        if (d != matching::kUnknown16) known.push_back(d);
    const std::size_t few =
        std::max(kLeastPixels, static_cast<std::size_t>(kLeastShare * static_cast<double>(known.size())));
    if (known.size() <= few) return std::nullopt;
    const auto nth_px = [&](std::size_t n) {
        const double nth = value_at_rank(known, n);
        return match.small.scale * (match.min_px + nth / static_cast<double>(matching::kOnePixel));
    };
    return Extremes{nth_px(few), nth_px(known.size() - few - 1)};
}

double largest_disparity_px(const SmallMatch& match) {
    const std::optional<Extremes> extremes = extremes_of(match);
    return extremes ? extremes->largest_px : 0;
}

int floor_of(int min_px, const ReducedPair& small) {
    return static_cast<int>(std::floor(min_px / small.scale));
}

int entries(double from_px, double to_px, const ReducedPair& small) {
    const int most = std::min(small.pair.left.width, kLargestRange_px);
    return std::clamp(static_cast<int>(std::ceil((to_px - from_px) / small.scale)) + 1, 1, most);
}

constexpr float kUnsure_px = 1;  // above the least disparity searched
constexpr double kFarShare = 0.01;
constexpr double kMedians = 10;
constexpr std::size_t kLeastMatches = 100;

std::vector<float> sure_matches(const DisparityMap& map, double least_px) {
    std::vector<float> sure;
    for (std::size_t i = 0; i < map.values.size(); ++i)
        if (map.origins[i] == PixelOrigin::matched && map.values[i] > least_px) sure.push_back(map.values[i]);
    return sure;
}

double quantile(std::vector<float>& values, double share) {
    return value_at_rank(values, static_cast<std::size_t>(share * static_cast<double>(values.size())));
}

}  // namespace

SmallMatch match_coarsely(const StereoPair& pair, int min_px, int threads, int columns) {
    return match_between(pair, min_px, pair.left.width + std::min(0, min_px), threads, columns);
}

SmallMatch match_between(const StereoPair& pair, int min_px, int max_px, int threads, int columns) {
    ReducedPair coarse = reduced(pair, columns, threads);
    const matching::DisparityRange range{floor_of(min_px, coarse), entries(min_px, max_px, coarse)};
    return match_small(std::move(coarse), range, kCoarseSpeckle, threads);
}

int choose_num_disparities(const StereoPair& pair, const SmallMatch& coarse, int min_px, int threads) {
    const int width = pair.left.width;
    const int widest =
        std::min(round_up_range(width), round_up_range(kLargestRange_px - std::max(0, min_px)) - 16);
    double largest_px = largest_disparity_px(coarse);
    if (largest_px <= min_px) return std::min(widest, round_up_range(width / 4));
    double scale = coarse.small.scale;
    if (scale > 1) {
        ReducedPair fine = reduced(pair, kFineColumns, threads);
        const double reach_px = kFineReach * largest_px + 2 * scale;
        const matching::DisparityRange range{floor_of(min_px, fine), entries(min_px, reach_px, fine)};
        scale = fine.scale;
        largest_px = std::max(
            largest_px, largest_disparity_px(match_small(std::move(fine), range, kFineSpeckle, threads)));
    }
    const double with_margin_px = largest_px + kMargin * std::fabs(largest_px) + kNearMargin_px * scale;
    const int count = round_up_range(static_cast<int>(std::ceil(with_margin_px)) - min_px + 1);
    return std::clamp(count, 16, std::max(16, widest));
}

double farthest_disparity_px(const SmallMatch& coarse) {
    const std::optional<Extremes> extremes = extremes_of(coarse);
    if (!extremes) return std::numeric_limits<double>::quiet_NaN();
    const double least_px = extremes->least_px;
    const double with_margin_px =
        least_px - kMargin * std::fabs(least_px) - kFarMargin_px * coarse.small.scale;
    return std::floor(matching::kOnePixel * with_margin_px) / matching::kOnePixel;
}

std::optional<Backdrop> put_backdrop(DisparityMap& map, int min_px, double doffs_px, double farthest) {
    // Nothing at or behind infinity has a depth.
    std::vector<float> sure =
        sure_matches(map, std::max(static_cast<double>(min_px) + kUnsure_px, -doffs_px));
    if (sure.size() < kLeastMatches) return std::nullopt;
    const double far = quantile(sure, kFarShare) + doffs_px, median = quantile(sure, 0.5) + doffs_px;
    Backdrop backdrop{static_cast<float>(std::max(far, median / kMedians) / farthest - doffs_px)};
    std::size_t known = 0, moved = 0;
    for (float& d : map.values) {
        if (!DisparityMap::known(d)) continue;
        ++known;
        if (!(d < backdrop.disparity_px)) continue;
        d = backdrop.disparity_px;
        ++moved;
    }
    backdrop.moved_share = static_cast<double>(moved) / static_cast<double>(known);
    return backdrop;
}

std::size_t press_near(DisparityMap& map, double nearest_px) {
    const auto limit = static_cast<float>(nearest_px);
    const auto is_near = [&](float d) { return DisparityMap::known(d) && d > limit; };
    std::size_t moved = 0;
    std::vector<std::size_t> part;
    std::vector<float> border;
    std::vector<std::uint8_t> is_taken(map.values.size(), 0);
    for (std::size_t start = 0; start < map.values.size(); ++start) {
        if (is_taken[start] || !is_near(map.values[start])) continue;
        part.assign(1, start);
        border.clear();
        is_taken[start] = 1;
        for (std::size_t i = 0; i < part.size(); ++i)
            for_four_neighbours(part[i], map.width, map.height, [&](std::size_t at) {
                const float d = map.values[at];
                if (!DisparityMap::known(d) || is_taken[at]) return;
                if (!is_near(d)) return border.push_back(d);
                is_taken[at] = 1;
                part.push_back(at);
            });
        const float d = border.empty() ? limit : static_cast<float>(quantile(border, 0.5));
        for (const std::size_t at : part) map.values[at] = d;
        moved += part.size();
    }
    return moved;
}

}  // namespace hexrelief::stages
