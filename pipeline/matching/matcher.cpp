#include "pipeline/matching/matcher.h"

#include <utility>

#include "pipeline/matching/common/color_planes.h"
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

}  // namespace hexrelief::matching
