#include "pipeline/matching/refine/refine.h"

#include <utility>
#include <vector>

#include "pipeline/matching/common/for_each_row.h"
#include "pipeline/matching/refine/certainty.h"
#include "pipeline/matching/refine/fill.h"
#include "pipeline/matching/refine/frame_segment_step.h"
#include "pipeline/matching/refine/match_colors.h"
#include "pipeline/matching/refine/side_step.h"
#include "pipeline/matching/refine/sides.h"
#include "pipeline/matching/refine/smooth.h"
#include "pipeline/matching/refine/vote_step.h"
#include "pipeline/matching/refine/voter_step.h"
#include "pipeline/matching/refine/votes.h"

namespace hexrelief::matching {
namespace {

struct VoterInput {
    const Raster<std::uint8_t>& matched;
    const Disparities16& filled;
    const PairColors& colors;
    const Raster<std::int32_t>& nearest_seen;
    int min_px;
};

Raster<std::uint8_t> first_round_weights(const VoterInput& in, ThreadPool& pool) {
    const int width = in.matched.width();
    const ColorView left = view_of(in.colors.left), right = view_of(in.colors.right);
    const Raster<step::Certainty> certainty =
        find_certainty({in.filled, in.colors, in.nearest_seen, in.min_px}, pool);
    Raster<std::uint8_t> weights(width, in.matched.height(), 0);
    for_each_row(pool, in.matched.height(), [&](int y) {
        for (int x = 0; x < width; ++x) {
            std::uint8_t& weight = weights.view().at(x, y);
            weight = step::kMatchedWeight;
            if (in.matched.view().at(x, y) && certainty.view().at(x, y) == step::Certainty::right) continue;
            const int disparity = in.filled.view().at(x, y);
            const step::RowSite site{x, width, in.min_px, in.nearest_seen.view().row(y)};
            weight = step::filled_weight(site, disparity, left.channels > 1, [&] {
                return window_difference(left, right, x, y, step::position_in_right(x, in.min_px, disparity));
            });
        }
    });
    return weights;
}

Raster<std::uint8_t> later_weights(const CertaintyInput& in, ThreadPool& pool) {
    const Raster<step::Certainty> certainty = find_certainty(in, pool);
    Raster<std::uint8_t> weights(in.map.width(), in.map.height(), 0);
    for_each_row(pool, in.map.height(), [&](int y) {
        for (int x = 0; x < in.map.width(); ++x)
            weights.view().at(x, y) = step::later_weight(certainty.view().at(x, y));
    });
    return weights;
}

void open_holes(const Raster<std::uint8_t>& weights, Raster<VoteWindow>& windows, ThreadPool& pool) {
    for_each_row(pool, weights.height(), [&](int y) {
        for (int x = 0; x < weights.width(); ++x)
            if (step::is_hole(weights.view().at(x, y))) windows.view().at(x, y) = VoteWindow::hole;
    });
}

void raise_frame_segments(const FrameSegments& segments, const DisparityView& matches,
                          const DisparityOut& filled) {
    const CellGrid& grid = segments.grid;
    std::vector<std::int16_t> samples;
    for (int row = 0; row < grid.rows; ++row)
        for (int column = 0; column < grid.columns; ++column) {
            const int x = step::middle_of_cell(column, grid.cell_px);
            const int y = step::middle_of_cell(row, grid.cell_px);
            samples.push_back(step::unmatched(matches.at(x, y), filled.at(x, y)));
        }
    const std::vector<std::int16_t> least = least_disparities(segments, samples);
    for (std::size_t cell = 0; cell < grid.size(); ++cell) {
        if (least[cell] == kUnknown16) continue;
        const int first_x = static_cast<int>(cell) % grid.columns * grid.cell_px;
        const int first_y = static_cast<int>(cell) / grid.columns * grid.cell_px;
        for (int y = first_y; y < first_y + grid.cell_px; ++y)
            for (int x = first_x; x < first_x + grid.cell_px; ++x)
                filled.at(x, y) = step::raised(matches.at(x, y), filled.at(x, y), least[cell]);
    }
}

}  // namespace

Raster<std::uint8_t> known_pixels(const Disparities16& map, ThreadPool& pool) {
    Raster<std::uint8_t> known(map.width(), map.height(), 0);
    for_each_row(pool, map.height(), [&](int y) {
        for (int x = 0; x < map.width(); ++x) known.view().at(x, y) = map.view().at(x, y) != kUnknown16;
    });
    return known;
}

RefinedMap refine(const RefineInput& input, const ConsistencyConfig& config, ThreadPool& pool) {
    const PairColors& colors = input.colors;
    TrustedMatches matches = find_trusted_matches(input.views, config, pool);
    Raster<std::uint8_t> matched = known_pixels(matches.left, pool);
    if (input.half_size) add_half_size_matches(*input.half_size, config.min_px, matches, pool);
    Disparities16 map = fill_unknown({matches, find_slopes(matches.left, pool), colors, config.min_px}, pool);
    raise_frame_segments(input.frame_segments, std::as_const(matches.left).view(), map.view());
    const ColorPlanes& left = colors.left;
    const ColorPlanes hole_colors = blurred(left, pool);
    for (int round = 0; round < step::kVoteRounds; ++round) {
        const bool first_round = round == 0;
        const Slopes slopes = find_slopes(map, pool);
        const Raster<std::uint8_t> weights =
            first_round
                ? first_round_weights({matched, map, colors, matches.nearest_seen, config.min_px}, pool)
                : later_weights({map, colors, matches.nearest_seen, config.min_px}, pool);
        Raster<VoteWindow> windows = near_discontinuities(map, pool);
        if (first_round) open_holes(weights, windows, pool);
        map = take_votes({map, slopes, left, hole_colors, matches.nearest_seen, weights, config.min_px},
                         windows, pool);
    }
    for (int round = 0; round < step::kSideRounds; ++round)
        map = choose_sides({map, left, colors.right, matches.nearest_seen, config.min_px}, pool);
    return {smoothed(median_filtered(map, pool), left, pool), std::move(matched)};
}

}  // namespace hexrelief::matching
