#include "pipeline/matching/refine/refine.h"

#include "pipeline/matching/common/rows.h"
#include "pipeline/matching/refine/fill.h"
#include "pipeline/matching/refine/sides.h"
#include "pipeline/matching/refine/smooth.h"
#include "pipeline/matching/refine/vote_step.h"
#include "pipeline/matching/refine/votes.h"

namespace hexrelief {
namespace {

Raster<std::uint8_t> first_round_weights(const Raster<std::uint8_t>& matched, const Disparities16& filled,
                                         int min_px, ThreadPool& pool) {
    Raster<std::uint8_t> weights(matched.width(), matched.height(), 0);
    for_each_row(pool, matched.height(), [&](int y) {
        for (int x = 0; x < matched.width(); ++x)
            weights.view().at(x, y) =
                step::first_round_weight(matched.view().at(x, y), x, min_px, filled.view().at(x, y));
    });
    return weights;
}

void open_holes(const Raster<std::uint8_t>& matched, Raster<VoteWindow>& windows, ThreadPool& pool) {
    for_each_row(pool, matched.height(), [&](int y) {
        for (int x = 0; x < matched.width(); ++x)
            if (!matched.view().at(x, y)) windows.view().at(x, y) = VoteWindow::hole;
    });
}

}  // namespace

Raster<std::uint8_t> known_pixels(const Disparities16& map, ThreadPool& pool) {
    Raster<std::uint8_t> known(map.width(), map.height(), 0);
    for_each_row(pool, map.height(), [&](int y) {
        for (int x = 0; x < map.width(); ++x) known.view().at(x, y) = map.view().at(x, y) != kUnknown16;
    });
    return known;
}

RefinedMap refine(const PairColors& colors, const ViewDisparities& views, const HalfSizeMatches* half_size,
                  const ConsistencyConfig& config, ThreadPool& pool) {
    TrustedMatches matches = find_trusted_matches(views, config, pool);
    Raster<std::uint8_t> matched = known_pixels(matches.left, pool);
    if (half_size) add_half_size_matches(*half_size, config.min_px, matches, pool);
    Disparities16 map =
        fill_unknown({matches, find_slopes(matches.left, kVoteSlopes, pool), colors, config.min_px}, pool);
    const ColorPlanes& left = colors.left;
    const ColorPlanes hole_colors = blurred(left, pool);
    for (const bool first_round : {true, false}) {
        const Slopes slopes = find_slopes(map, kVoteSlopes, pool);
        Raster<VoteWindow> windows = near_discontinuities(map, pool);
        if (first_round) open_holes(matched, windows, pool);
        const Raster<std::uint8_t> weights =
            first_round ? first_round_weights(matched, map, config.min_px, pool)
                        : Raster<std::uint8_t>(map.width(), map.height(), step::kMatchedWeight);
        map = take_votes({map, slopes, left, hole_colors, matches.nearest_seen, weights, config.min_px},
                         windows, pool);
    }
    map = choose_sides({map, left, colors.right, matches.nearest_seen, config.min_px}, pool);
    return {smoothed(median_filtered(map, pool), left, pool), std::move(matched)};
}

}  // namespace hexrelief
