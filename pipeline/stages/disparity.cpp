#include "pipeline/stages/disparity.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "pipeline/base/thread_pool.h"
#include "pipeline/data/error.h"
#include "pipeline/data/number_text.h"
#include "pipeline/stages/by_colour/bare_planes.h"
#include "pipeline/stages/by_colour/mixed_pixels.h"
#include "pipeline/stages/sgbm.h"

namespace hexrelief::stages {
namespace {

constexpr int kLeastColumns = 16;
constexpr double kSgbmLeftRight_px = 1;

std::string size_of(const Image& image) {
    return size_text(image.width, image.height);
}

}  // namespace

std::string wrong_disparity_config(const DisparityConfig& config) {
    using Config = DisparityConfig;
    const std::string outside = out_of_range({
        {"disparity.working_px", config.working_px, Config::kWorkingSize_px},
        {"disparity.min_disparity_px", config.min_disparity_px, Config::kMinDisparity_px},
        {"disparity.num_disparities_px", config.num_disparities_px, Config::kNumDisparities_px},
        {"disparity.timeout_s", config.timeout_s, Config::kTimeout_s},
        {"disparity.least_confidence", config.least_confidence, Config::kConfidence},
        {"disparity.p1", config.p1, Config::kPenalty},
        {"disparity.p2", config.p2, Config::kPenalty},
        {"disparity.speckle_window_px", config.speckle_window_px, Config::kSpeckleWindow_px},
        {"disparity.speckle_range_px", config.speckle_range_px, Config::kSpeckleRange_px},
        {"disparity.block_size_px", config.block_size_px, Config::kBlockSize_px},
        {"disparity.pre_filter_cap", config.pre_filter_cap, Config::kPreFilterCap},
        {"disparity.uniqueness_ratio_percent", config.uniqueness_ratio_percent,
         Config::kUniquenessRatio_percent},
    });
    if (!outside.empty()) return outside;
    if (config.working_px > 0 && config.working_px < Config::kLeastWorkingSize_px)
        return "disparity.working_px must be 0, for the pictures' own size, or at least " +
               std::to_string(Config::kLeastWorkingSize_px) + ", not " + std::to_string(config.working_px);
    if (config.block_size_px % 2 == 0)
        return "disparity.block_size_px must be odd, not " + std::to_string(config.block_size_px);
    if (config.method == DisparityMethod::command) {
        if (config.command.empty() == config.worker.empty())
            return "disparity.method=command needs one of disparity.command and disparity.worker";
        if (config.worker.empty() && config.command.find("{out") == std::string::npos)
            return "disparity.command must name {left}, {right} and {out}, the files of the pair and of the "
                   "map";
    }
    if (config.method == DisparityMethod::onnx && config.model.empty())
        return "disparity.method=onnx needs disparity.model, the network's ONNX file";
    if (config.p2 > 0 && config.p2 <= config.p1) return "disparity.p2 must be above disparity.p1";
    return {};
}

void check_matchable(const StereoPair& pair, const DisparityConfig& config) {
    const auto usage = [](bool good, const std::string& message) {
        if (!good) throw Error(ErrorKind::usage, "disparity." + message);
    };
    const Image &left = pair.left, &right = pair.right;
    if (left.width != right.width || left.height != right.height)
        throw Error(ErrorKind::input, "the left image is " + size_of(left) + ", the right one " +
                                          size_of(right) + "; a rectified pair has one size");
    if (left.width < kLeastColumns || left.height < 1)
        throw Error(ErrorKind::input,
                    "the images are " + size_of(left) + "; matching needs at least 16 columns and a row");
    if (const std::string wrong = wrong_disparity_config(config); !wrong.empty())
        throw Error(ErrorKind::usage, wrong);
    // Ranges are rounded up, whether they come from the configuration, the calibration or the pair.
    usage(config.num_disparities_px <= round_up_range(left.width),
          "num_disparities_px " + std::to_string(config.num_disparities_px) + " is wider than the image (" +
              std::to_string(left.width) + ")");
    usage(std::abs(config.min_disparity_px) < left.width &&
              config.min_disparity_px + round_up_range(config.num_disparities_px) <=
                  round_up_range(kLargestRange_px),
          "min_disparity_px must lie within the image's width, and the whole range below " +
              std::to_string(kLargestRange_px) + " px");
}

namespace {

void check(const StereoPair& pair, const DisparityConfig& config) {
    const Image& left = pair.left;
    if (std::max(left.width, left.height) > kLargestPairSide_px)
        throw Error(ErrorKind::input, "the images are " + size_of(left) + "; a pair's sides may have up to " +
                                          std::to_string(kLargestPairSide_px) +
                                          " px: match it by 'hexrelief tiles match', or scale it down");
    check_matchable(pair, config);
}

double left_right_limit_px(const DisparityConfig& config) {
    if (!std::isnan(config.left_right_check_px)) return config.left_right_check_px;
    return config.method == DisparityMethod::sgm
               ? matching::ConsistencyConfig{}.left_right_limit / static_cast<double>(matching::kOnePixel)
               : kSgbmLeftRight_px;
}

matching::MatchingConfig matching_config(const DisparityConfig& config) {
    matching::MatchingConfig matching;
    matching.range = {config.min_disparity_px, config.num_disparities_px};
    if (config.p1 > 0) matching.penalties.p1 = config.p1;
    if (config.p2 > 0) matching.penalties.p2 = config.p2;
    matching.penalties.p2 = std::max(matching.penalties.p2, matching.penalties.p1 + 1);
    const double limit_px = std::min(left_right_limit_px(config), 1000.0);
    matching.consistency = {config.min_disparity_px,
                            static_cast<int>(std::floor(limit_px * matching::kOnePixel)),
                            config.speckle_window_px, config.speckle_range_px * matching::kOnePixel};
    if (config.farthest_px > config.min_disparity_px)
        matching.consistency.least = static_cast<int>(
            matching::kOnePixel *
            std::min<double>(config.farthest_px - config.min_disparity_px, kLargestRange_px));
    return matching;
}

matching::Disparities16 above_least(const RawDisparities& raw, int min_px) {
    matching::Disparities16 map(raw.width, raw.height, matching::kUnknown16);
    for (int y = 0; y < raw.height; ++y)
        for (int x = 0; x < raw.width; ++x) {
            const int d = raw.values[static_cast<std::size_t>(y) * raw.width + x];
            if (d != kUnmatched)
                map.view().at(x, y) = static_cast<std::int16_t>(d - min_px * matching::kOnePixel);
        }
    return map;
}

matching::Disparities16 above_least(const DisparityMap& map, int min_px) {
    matching::Disparities16 above(map.width, map.height, matching::kUnknown16);
    for (int y = 0; y < map.height; ++y)
        for (int x = 0; x < map.width; ++x)
            if (const float d = map.at(x, y); DisparityMap::known(d))
                above.view().at(x, y) = static_cast<std::int16_t>(
                    std::floor((static_cast<double>(d) - min_px) * matching::kOnePixel + 0.5));
    return above;
}

// Refines the checked views as match_pair() refines its own.
matching::MatchedMap refine_sgbm(const StereoPair& pair, const DisparityConfig& config, int threads) {
    const RawViews views = match_views_sgbm(pair, config, threads);
    return matching::refine_views(
        pair,
        {above_least(views.left, config.min_disparity_px), above_least(views.right, config.min_disparity_px)},
        matching_config(config), threads);
}

DisparityMap to_pixels(matching::MatchedMap matched, const StereoPair& pair, const DisparityConfig& config,
                       int threads, std::optional<Pictures> planes = {}) {
    matching::continue_beyond_frame(matched, config.min_disparity_px);
    const std::size_t count = matched.disparities.size();
    DisparityMap map{matched.width, matched.height, std::vector<float>(count, kUnknownDisparity),
                     std::vector<PixelOrigin>(count, PixelOrigin::unknown)};
    ThreadPool(threads).parallel_for_each(count, [&](std::size_t i) {
        const bool is_matched = matched.is_matched[i] != 0;
        if (matched.disparities[i] == matching::kUnknown16) return;
        int d = matched.disparities[i] + config.min_disparity_px * matching::kOnePixel;
        if (d == 0) d = 1;
        map.values[i] = static_cast<float>(d) / matching::kOnePixel;
        map.origins[i] = is_matched ? PixelOrigin::matched : PixelOrigin::filled;
    });
    if (planes) map = with_planes_on_bare_patches(std::move(map), pair, *planes, threads);
    map = without_mixed_pixels(std::move(map), pair.left, Scraps::stay);
    if (config.fill == DisparityFill::none)
        for (std::size_t i = 0; i < count; ++i) {
            if (map.origins[i] != PixelOrigin::filled) continue;
            map.values[i] = kUnknownDisparity;
            map.origins[i] = PixelOrigin::unknown;
        }
    return map;
}

}  // namespace

PixelRect middle_of(int width, int height) {
    constexpr int kMost_px = 1024;
    const int columns = std::min(width, kMost_px), rows = std::min(height, kMost_px);
    return {(width - columns) / 2, (height - rows) / 2, columns, rows};
}

PairCorrection find_correction(const SmallMatch& coarse, const Image& left_middle, Image right_middle) {
    PairCorrection correction{matching::find_light(coarse.small.pair, coarse.map, coarse.min_px),
                              matching::find_noise(left_middle)};
    constexpr int kOneThread = 1;  // the image is small
    matching::relight(right_middle, correction.light, kOneThread);
    correction.right_noise = matching::find_noise(right_middle);
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
    matching::relight(pair.right, correction.light, threads);
    matching::denoise(pair.left, correction.left_noise, threads);
    matching::denoise(pair.right, correction.right_noise, threads);
    return pair;
}

DisparityMap match_range(const StereoPair& pair, const DisparityConfig& config, PairMatcher& matcher,
                         int threads, std::optional<Pictures> planes) {
    check(pair, config);
    DisparityConfig ranged = config;
    ranged.num_disparities_px = round_up_range(config.num_disparities_px);
    switch (config.method) {
        case DisparityMethod::sgm:
            return to_pixels(matcher.match_pair(pair, matching_config(ranged)), pair, config, threads,
                             planes);
        case DisparityMethod::sgbm:
            return to_pixels(refine_sgbm(pair, ranged, threads), pair, config, threads, planes);
        case DisparityMethod::command:
        case DisparityMethod::onnx:
            break;
    }
    throw Error(ErrorKind::usage,
                "disparity.method=command and onnx are for whole pairs of `run` and `batch`; take sgm here");
}

DisparityMap refine_maps(const StereoPair& pair, const ViewMaps& views, const DisparityConfig& config,
                         int threads) {
    KnownRange range = known_range(views.left);
    range.add(views.right);
    if (range.is_empty()) return {views.left.width, views.left.height, views.left.values, {}};
    const auto [least, largest] = range;
    if (largest - least >= static_cast<float>(kLargestRange_px - 1) || std::abs(least) >= kLargestRange_px)
        throw Error(ErrorKind::input, "the map's disparities reach from " +
                                          std::to_string(std::lround(least)) + " to " +
                                          std::to_string(std::lround(largest)) + " px; at most " +
                                          std::to_string(kLargestRange_px) + " px are meshed");
    DisparityConfig ranged = config;
    ranged.min_disparity_px = static_cast<int>(std::floor(least));
    ranged.num_disparities_px = static_cast<int>(std::floor(largest)) - ranged.min_disparity_px + 1;
    return to_pixels(matching::refine_views(pair,
                                            {above_least(views.left, ranged.min_disparity_px),
                                             above_least(views.right, ranged.min_disparity_px)},
                                            matching_config(ranged), threads),
                     pair, ranged, threads);
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

matching::MatchedMap CpuMatcher::match_pair(const StereoPair& pair, const matching::MatchingConfig& config) {
    return matching::match_pair(pair, config, threads_);
}

}  // namespace hexrelief::stages
