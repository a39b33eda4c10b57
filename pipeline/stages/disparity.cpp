#include "pipeline/stages/disparity.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "mesher/common/thread_pool.h"
#include "pipeline/data/error.h"
#include "pipeline/stages/sgbm.h"
#include "pipeline/stages/view_check.h"

namespace hexrelief {
namespace {

constexpr int kLeastColumns = 16;
constexpr double kSgbmLeftRight_px = 1;

std::string size_of(const Image& image) {
    return std::to_string(image.width) + "x" + std::to_string(image.height);
}

}  // namespace

void check_matchable(const StereoPair& pair, const DisparityConfig& config) {
    const auto usage = [](bool good, const std::string& message) {
        if (!good) throw Error(ErrorKind::usage, "disparity." + message);
    };
    const Image &left = pair.left, &right = pair.right;
    if (left.width != right.width || left.height != right.height) {
        throw Error(ErrorKind::input, "the left image is " + size_of(left) + ", the right one " +
                                          size_of(right) + "; a rectified pair has one size");
    }
    if (left.width < kLeastColumns || left.height < 1) {
        throw Error(ErrorKind::input,
                    "the images are " + size_of(left) + "; matching needs at least 16 columns and a row");
    }
    usage(config.block_size_px >= 1 && config.block_size_px <= 21 && config.block_size_px % 2 == 1,
          "block_size_px must be odd and between 1 and 21");
    usage(config.pre_filter_cap >= 1 && config.pre_filter_cap <= 127,
          "pre_filter_cap must be between 1 and 127");
    usage(config.uniqueness_ratio_percent >= 0 && config.uniqueness_ratio_percent <= 99,
          "uniqueness_ratio_percent must be between 0 and 99");
    usage(config.p1 >= 0 && config.p1 <= kLargestPenalty, "p1 must be between 0 and 16000");
    usage(config.p2 >= 0 && config.p2 <= kLargestPenalty, "p2 must be between 0 and 16000");
    usage(config.p2 == 0 || config.p2 > config.p1, "p2 must be larger than p1");
    usage(config.num_disparities_px >= 0, "num_disparities_px must not be negative");
    usage(config.speckle_window_px >= 0, "speckle_window_px must not be negative");
    usage(!config.wls || config.method == DisparityMethod::sgbm,
          "wls filters StereoSGBM's disparities; set disparity.method to sgbm, or disparity.wls to false");
    usage(config.speckle_range_px >= 0 && config.speckle_range_px <= kLargestRange_px,
          "speckle_range_px must be between 0 and 1920");
    // A range is rounded up, be it the configuration's, the calibration's or one that was chosen.
    usage(config.num_disparities_px <= round_up_range(left.width),
          "num_disparities_px " + std::to_string(config.num_disparities_px) + " is wider than the image (" +
              std::to_string(left.width) + ")");
    const int widest = std::min(left.width, kLargestRange_px);
    usage(std::abs(config.min_disparity_px) < widest &&
              config.min_disparity_px + round_up_range(config.num_disparities_px) <=
                  round_up_range(kLargestRange_px),
          "min_disparity_px must lie within the image's width, and the whole range below 1920 px");
}

namespace {

void check(const StereoPair& pair, const DisparityConfig& config) {
    const Image& left = pair.left;
    if (std::max(left.width, left.height) > kLargestPairSide_px) {
        throw Error(ErrorKind::input, "the images are " + size_of(left) + "; a pair's sides may have up to " +
                                          std::to_string(kLargestPairSide_px) +
                                          " px: match it by 'hexrelief tiles match', or scale it down");
    }
    check_matchable(pair, config);
}

double left_right_limit_px(const DisparityConfig& config) {
    if (!std::isnan(config.left_right_check_px)) return config.left_right_check_px;
    return config.method == DisparityMethod::sgm
               ? ConsistencyConfig{}.left_right_limit / static_cast<double>(kOnePixel)
               : kSgbmLeftRight_px;
}

MatchingConfig matching_config(const DisparityConfig& config) {
    MatchingConfig matching;
    matching.range = {config.min_disparity_px, config.num_disparities_px};
    if (config.p1 > 0) matching.penalties.p1 = config.p1;
    if (config.p2 > 0) matching.penalties.p2 = config.p2;
    matching.penalties.p2 = std::max(matching.penalties.p2, matching.penalties.p1 + 1);
    const double limit_px = std::min(left_right_limit_px(config), 1000.0);
    matching.consistency = {config.min_disparity_px, static_cast<int>(std::floor(limit_px * kOnePixel)),
                            config.speckle_window_px, config.speckle_range_px * kOnePixel};
    if (config.farthest_px > config.min_disparity_px)
        matching.consistency.least = static_cast<int>(
            kOnePixel * std::min<double>(config.farthest_px - config.min_disparity_px, kLargestRange_px));
    return matching;
}

Disparities16 above_least(const RawDisparities& raw, int min_px) {
    Disparities16 map(raw.width, raw.height, kUnknown16);
    for (int y = 0; y < raw.height; ++y)
        for (int x = 0; x < raw.width; ++x) {
            const int d = raw.values[static_cast<std::size_t>(y) * raw.width + x];
            if (d != kUnmatched) map.view().at(x, y) = static_cast<std::int16_t>(d - min_px * kOnePixel);
        }
    return map;
}

// The checked views are refined as the own matcher's are.
MatchedMap refine_sgbm(const StereoPair& pair, const DisparityConfig& config, int threads) {
    const RawViews views = match_views_sgbm(pair, config, threads);
    return refine_views(
        pair,
        {above_least(views.left, config.min_disparity_px), above_least(views.right, config.min_disparity_px)},
        matching_config(config), threads);
}

MatchedMap filter_sgbm(const StereoPair& pair, const DisparityConfig& config, int threads) {
    const RawViews views = match_views_sgbm(pair, config, threads);
    RawDisparities checked = views.left;
    const double limit_px = left_right_limit_px(config);
    if (limit_px >= 0) check_left_right(checked, views.right, limit_px);
    remove_speckles(checked, config.speckle_window_px, config.speckle_range_px);
    const RawDisparities matched = checked;
    smooth_wls(checked, views, pair.left, config);
    MatchedMap map{checked.width, checked.height, {}, {}};
    for (std::size_t i = 0; i < checked.values.size(); ++i) {
        const int d = checked.values[i];
        map.disparities.push_back(d == kUnmatched ? kUnknown16
                                                  : static_cast<std::int16_t>(std::max(
                                                        0, d - config.min_disparity_px * kOnePixel)));
        map.is_matched.push_back(matched.values[i] != kUnmatched);
    }
    return map;
}

DisparityMap to_pixels(const MatchedMap& matched, const DisparityConfig& config, int threads) {
    const std::size_t count = matched.disparities.size();
    DisparityMap map{matched.width, matched.height, std::vector<float>(count, kUnknownDisparity),
                     std::vector<PixelOrigin>(count, PixelOrigin::unknown)};
    ThreadPool(threads).parallel_for(count, [&](std::size_t first, std::size_t last) {
        for (std::size_t i = first; i < last; ++i) {
            const bool is_matched = matched.is_matched[i] != 0;
            if (matched.disparities[i] == kUnknown16) continue;
            if (!is_matched && config.fill == DisparityFill::none) continue;
            int d = matched.disparities[i] + config.min_disparity_px * kOnePixel;
            if (d == 0) d = 1;
            map.values[i] = static_cast<float>(d) / kOnePixel;
            map.origins[i] = is_matched ? PixelOrigin::matched : PixelOrigin::filled;
        }
    });
    return map;
}

}  // namespace

PixelRect middle_of(int width, int height) {
    constexpr int kMost_px = 1024;
    const int columns = std::min(width, kMost_px), rows = std::min(height, kMost_px);
    return {(width - columns) / 2, (height - rows) / 2, columns, rows};
}

PairCorrection find_correction(const SmallMatch& coarse, const Image& left_middle, Image right_middle) {
    PairCorrection correction{find_light(coarse.small.pair, coarse.map, coarse.min_px),
                              find_noise(left_middle)};
    constexpr int kOneThread = 1;  // it is small
    relight(right_middle, correction.light, kOneThread);
    correction.right_noise = find_noise(right_middle);
    return correction;
}

int num_disparities_by(const Calibration& calibration, const DisparityConfig& config, int width) {
    const int below_ndisp = calibration.ndisp_px - config.min_disparity_px;
    if (config.num_disparities_px > 0 || calibration.ndisp_px <= 0 || below_ndisp <= 0) return 0;
    return std::min({below_ndisp, width, kLargestRange_px - std::max(0, config.min_disparity_px)});
}

FoundRange find_range(const StereoPair& pair, const Calibration& calibration, const DisparityConfig& config,
                      int threads) {
    FoundRange found{config};
    const int by_calibration = num_disparities_by(calibration, config, pair.left.width);
    int& count = found.config.num_disparities_px;
    if (count > 0) found.origin = RangeOrigin::given;
    if (by_calibration > 0) {
        found.origin = RangeOrigin::ndisp;
        count = by_calibration;
    }
    check(pair, found.config);
    const int min_px = config.min_disparity_px;
    found.coarse = match_coarsely(pair, min_px, threads);
    const PixelRect middle = middle_of(pair.left.width, pair.left.height);
    found.correction = find_correction(found.coarse, cropped(pair.left, middle), cropped(pair.right, middle));
    count = count > 0 ? round_up_range(count) : choose_num_disparities(pair, found.coarse, min_px, threads);
    double& farthest_px = found.config.farthest_px;
    if (std::isnan(farthest_px)) farthest_px = farthest_disparity_px(found.coarse);
    return found;
}

StereoPair corrected(StereoPair pair, const PairCorrection& correction, int threads) {
    relight(pair.right, correction.light, threads);
    denoise(pair.left, correction.left_noise, threads);
    denoise(pair.right, correction.right_noise, threads);
    return pair;
}

DisparityMap match_range(const StereoPair& pair, const DisparityConfig& config, PairMatcher& matcher,
                         int threads) {
    check(pair, config);
    DisparityConfig ranged = config;
    ranged.num_disparities_px = round_up_range(config.num_disparities_px);
    if (config.method == DisparityMethod::sgm)
        return to_pixels(matcher.match_pair(pair, matching_config(ranged)), config, threads);
    return to_pixels(config.wls ? filter_sgbm(pair, ranged, threads) : refine_sgbm(pair, ranged, threads),
                     config, threads);
}

DisparityMap compute_disparity(const StereoPair& pair, const DisparityConfig& config, PairMatcher& matcher,
                               int threads) {
    const FoundRange range = find_range(pair, {}, config, threads);
    return match_range(corrected(pair, range.correction, threads), range.config, matcher, threads);
}

DisparityMap compute_disparity(const StereoPair& pair, const DisparityConfig& config, int threads) {
    CpuMatcher on_cpu(threads);
    return compute_disparity(pair, config, on_cpu, threads);
}

MatchedMap CpuMatcher::match_pair(const StereoPair& pair, const MatchingConfig& config) {
    return hexrelief::match_pair(pair, config, threads_);
}

}  // namespace hexrelief
